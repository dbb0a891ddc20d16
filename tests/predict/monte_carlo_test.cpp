// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "check_covariance.hpp"
#include "limber/core/factors.hpp"
#include "limber/predict/motion.hpp"
#include "navigation_error.hpp"

/// The predicted covariance against that of thousands of noisy runs.
namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::error_between;
using testing::Generator;
using testing::random_normal;
using testing::retracted;

constexpr int kRuns = 6000;
constexpr int kSteps = 100;
constexpr double kDt = 0.01;
constexpr double kDiscrete = 0.01;  // what finite steps may be off

Vector3d normal3(Generator& generator) { return random_normal(generator, 3); }

/// Inputs of a tumbling, accelerating body.
Vector3d omega_at(int k) { return {0.4 * std::sin(0.05 * k), 0.3, 0.5 * std::cos(0.03 * k)}; }
Vector3d force_at(int k) { return {2.0 * std::cos(0.04 * k), -1.0, 9.81 + std::sin(0.1 * k)}; }

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
  const MatrixXd L_0 = Cholesky(P_0).L();

  NavigationState estimate = start;
  MatrixXd P = P_0;
  for (int k = 0; k < kSteps; ++k) {
    const Transition step = predict_imu(estimate, omega_at(k), force_at(k), kDt, noise, 9.81);
    P = congruence(step.Phi, P) + step.Q;
  }
  testing::SampleCovariance errors(15);
  for (int run = 0; run < kRuns; ++run) {
    NavigationState truth = retracted(start, MotionModel::kImu, L_0 * random_normal(generator, 15));
    for (int k = 0; k < kSteps; ++k) {
      const Vector3d omega = omega_at(k) - per_sample * noise.gyro_density * normal3(generator);
      const Vector3d force = force_at(k) - per_sample * noise.accel_density * normal3(generator);
      (void)predict_imu(truth, omega, force, kDt, noise, 9.81);
      truth.bias_gyro += noise.gyro_walk * std::sqrt(kDt) * normal3(generator);
      truth.bias_accel += noise.accel_walk * std::sqrt(kDt) * normal3(generator);
    }
    errors.add(error_between(truth, estimate, MotionModel::kImu));
  }
  errors.expect(P, kDiscrete);
}

TEST(PredictConstantVelocity, CovarianceIsThatOfManyNoisyRuns) {
  Generator generator(12);
  const ConstantVelocityNoise noise{0.5, 0.02};
  NavigationState start;
  start.v_world_body << 1.0, 2.0, -0.5;
  start.omega_body << 0.2, -0.3, 0.4;
  const MatrixXd P_0 = small_initial_covariance(12);
  const MatrixXd L_0 = Cholesky(P_0).L();

  NavigationState estimate = start;
  MatrixXd P = P_0;
  for (int k = 0; k < kSteps; ++k) {
    const Transition step = predict_constant_velocity(estimate, kDt, noise);
    P = congruence(step.Phi, P) + step.Q;
  }
  testing::SampleCovariance errors(12);
  for (int run = 0; run < kRuns; ++run) {
    NavigationState truth =
        retracted(start, MotionModel::kConstantVelocity, L_0 * random_normal(generator, 12));
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
    errors.add(error_between(truth, estimate, MotionModel::kConstantVelocity));
  }
  errors.expect(P, kDiscrete);
}

TEST(PredictOdometry, CovarianceIsThatOfManyNoisyRuns) {
  Generator generator(13);
  OdometryNoise noise;
  noise.sigma_v << 0.1, 0.05, 0.02;
  noise.sigma_omega << 0.01, 0.02, 0.03;
  const NavigationState start;
  const MatrixXd P_0 = small_initial_covariance(6);
  const MatrixXd L_0 = Cholesky(P_0).L();
  const auto v_at = [](int k) { return Vector3d(2.0, 0.1 * std::sin(0.1 * k), 0.0); };

  NavigationState estimate = start;
  MatrixXd P = P_0;
  for (int k = 0; k < kSteps; ++k) {
    const Transition step = predict_odometry(estimate, v_at(k), omega_at(k), kDt, noise);
    P = congruence(step.Phi, P) + step.Q;
  }
  testing::SampleCovariance errors(6);
  for (int run = 0; run < kRuns; ++run) {
    NavigationState truth = retracted(start, MotionModel::kOdometry, L_0 * random_normal(generator, 6));
    for (int k = 0; k < kSteps; ++k) {
      const Vector3d v = v_at(k) - noise.sigma_v.cwiseProduct(normal3(generator));
      const Vector3d omega = omega_at(k) - noise.sigma_omega.cwiseProduct(normal3(generator));
      (void)predict_odometry(truth, v, omega, kDt, noise);
    }
    errors.add(error_between(truth, estimate, MotionModel::kOdometry));
  }
  errors.expect(P, kDiscrete);
}

}  // namespace
}  // namespace limber
