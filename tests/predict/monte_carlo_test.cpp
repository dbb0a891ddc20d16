// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "limber/core/chi_square.hpp"
#include "limber/predict/motion.hpp"
#include "navigation_error.hpp"

/// The predicted covariance against that of thousands of noisy runs. The whitened sample covariance of N
/// draws in n dimensions has singular values of its root within 1 ± (sqrt(n/N) + t), but for a chance of
/// 2 exp(−N t²/2) [Davidson and Szarek 2001]; t is chosen for one in a million.
namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::error_between;
using testing::Generator;
using testing::retracted;

constexpr int kRuns = 6000;
constexpr int kSteps = 100;
constexpr double kDt = 0.01;
constexpr double kFalseAlarm = 1e-6;

VectorXd normal(Generator& generator, Eigen::Index n) {
  std::normal_distribution<double> draw;
  return VectorXd::NullaryExpr(n, [&] { return draw(generator); });
}

Vector3d normal3(Generator& generator) { return normal(generator, 3); }

/// Inputs of a tumbling, accelerating body.
Vector3d omega_at(int k) { return {0.4 * std::sin(0.05 * k), 0.3, 0.5 * std::cos(0.03 * k)}; }
Vector3d force_at(int k) { return {2.0 * std::cos(0.04 * k), -1.0, 9.81 + std::sin(0.1 * k)}; }

/// Sums up draws of an error and judges them against its predicted covariance.
class Judge {
 public:
  explicit Judge(Eigen::Index n) : sum_(VectorXd::Zero(n)), outer_(MatrixXd::Zero(n, n)) {}

  void add(const VectorXd& error) {
    sum_ += error;
    outer_ += error * error.transpose();
  }

  void expect_covariance(const MatrixXd& P) const {
    const double n = static_cast<double>(P.rows());
    const Eigen::LLT<MatrixXd> llt(P);
    ASSERT_EQ(llt.info(), Eigen::Success);
    const VectorXd mean = llt.matrixL().solve(sum_ / std::sqrt(double{kRuns}));
    EXPECT_LE(mean.squaredNorm(), chi_square_quantile(1.0 - kFalseAlarm, n));
    const MatrixXd half = llt.matrixL().solve(outer_ / kRuns);
    const MatrixXd white = llt.matrixL().solve(half.transpose());
    const VectorXd roots =
        Eigen::SelfAdjointEigenSolver<MatrixXd>(white).eigenvalues().cwiseMax(0.0).cwiseSqrt();
    const double t = std::sqrt(2.0 * std::log(2.0 / kFalseAlarm) / kRuns);
    const double band = std::sqrt(n / kRuns) + t + 0.01;  // and 1 % for the discrete steps
    EXPECT_GE(roots.minCoeff(), 1.0 - band);
    EXPECT_LE(roots.maxCoeff(), 1.0 + band);
  }

 private:
  VectorXd sum_;
  MatrixXd outer_;
};

MatrixXd small_initial_covariance(Eigen::Index n) {
  VectorXd sigma = VectorXd::Constant(n, 0.01);
  sigma.segment<3>(3).setConstant(0.002);
  if (n > 6) {
    sigma.tail(n - 9).setConstant(0.003);
  }
  return sigma.cwiseAbs2().asDiagonal();
}

TEST(PredictImu, CovarianceIsThatOfManyNoisyRuns) {
  Generator generator(11);
  const ImuNoise noise{0.002, 0.002, 0.03, 0.02};
  const double per_sample = 1.0 / std::sqrt(kDt);
  const NavigationState start;
  const MatrixXd P_0 = small_initial_covariance(15);
  const MatrixXd L_0 = P_0.llt().matrixL();

  NavigationState estimate = start;
  MatrixXd P = P_0;
  for (int k = 0; k < kSteps; ++k) {
    const Transition step = predict_imu(estimate, omega_at(k), force_at(k), kDt, noise, 9.81);
    P = (step.Phi * P * step.Phi.transpose() + step.Q).eval();
  }
  Judge judge(15);
  for (int run = 0; run < kRuns; ++run) {
    NavigationState truth = retracted(start, MotionModel::kImu, L_0 * normal(generator, 15));
    for (int k = 0; k < kSteps; ++k) {
      const Vector3d omega = omega_at(k) - per_sample * noise.gyro_density * normal3(generator);
      const Vector3d force = force_at(k) - per_sample * noise.accel_density * normal3(generator);
      (void)predict_imu(truth, omega, force, kDt, noise, 9.81);
      truth.bias_gyro += noise.gyro_walk * std::sqrt(kDt) * normal3(generator);
      truth.bias_accel += noise.accel_walk * std::sqrt(kDt) * normal3(generator);
    }
    judge.add(error_between(truth, estimate, MotionModel::kImu));
  }
  judge.expect_covariance(P);
}

TEST(PredictConstantVelocity, CovarianceIsThatOfManyNoisyRuns) {
  Generator generator(12);
  const ConstantVelocityNoise noise{0.5, 0.02};
  NavigationState start;
  start.v_world_body << 1.0, 2.0, -0.5;
  start.omega_body << 0.2, -0.3, 0.4;
  const MatrixXd P_0 = small_initial_covariance(12);
  const MatrixXd L_0 = P_0.llt().matrixL();

  NavigationState estimate = start;
  MatrixXd P = P_0;
  for (int k = 0; k < kSteps; ++k) {
    const Transition step = predict_constant_velocity(estimate, kDt, noise);
    P = (step.Phi * P * step.Phi.transpose() + step.Q).eval();
  }
  Judge judge(12);
  for (int run = 0; run < kRuns; ++run) {
    NavigationState truth = retracted(start, MotionModel::kConstantVelocity, L_0 * normal(generator, 12));
    for (int k = 0; k < kSteps; ++k) {
      // Half of the kick before the step, half after it: the mean of where it may fall.
      const Vector3d dv = noise.acceleration_density * std::sqrt(kDt) * normal3(generator);
      const Vector3d dw = noise.angular_acceleration_density * std::sqrt(kDt) * normal3(generator);
      truth.v_world_body += 0.5 * dv;
      truth.omega_body += 0.5 * dw;
      (void)predict_constant_velocity(truth, kDt, noise);
      truth.v_world_body += 0.5 * dv;
      truth.omega_body += 0.5 * dw;
    }
    judge.add(error_between(truth, estimate, MotionModel::kConstantVelocity));
  }
  judge.expect_covariance(P);
}

TEST(PredictOdometry, CovarianceIsThatOfManyNoisyRuns) {
  Generator generator(13);
  OdometryNoise noise;
  noise.sigma_v << 0.1, 0.05, 0.02;
  noise.sigma_omega << 0.01, 0.02, 0.03;
  const NavigationState start;
  const MatrixXd P_0 = small_initial_covariance(6);
  const MatrixXd L_0 = P_0.llt().matrixL();
  const auto v_at = [](int k) { return Vector3d(2.0, 0.1 * std::sin(0.1 * k), 0.0); };

  NavigationState estimate = start;
  MatrixXd P = P_0;
  for (int k = 0; k < kSteps; ++k) {
    const Transition step = predict_odometry(estimate, v_at(k), omega_at(k), kDt, noise);
    P = (step.Phi * P * step.Phi.transpose() + step.Q).eval();
  }
  Judge judge(6);
  for (int run = 0; run < kRuns; ++run) {
    NavigationState truth = retracted(start, MotionModel::kOdometry, L_0 * normal(generator, 6));
    for (int k = 0; k < kSteps; ++k) {
      const Vector3d v = v_at(k) - noise.sigma_v.cwiseProduct(normal3(generator));
      const Vector3d omega = omega_at(k) - noise.sigma_omega.cwiseProduct(normal3(generator));
      (void)predict_odometry(truth, v, omega, kDt, noise);
    }
    judge.add(error_between(truth, estimate, MotionModel::kOdometry));
  }
  judge.expect_covariance(P);
}

}  // namespace
}  // namespace limber
