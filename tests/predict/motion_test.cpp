// SPDX-License-Identifier: MIT
#include "limber/predict/motion.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "check_jacobian.hpp"
#include "navigation_error.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::check_jacobian;
using testing::error_between;
using testing::Generator;
using testing::random_navigation_state;
using testing::random_vector;
using testing::retracted;

constexpr double kGravity = 9.81;

/// Steps from a microsecond to a long gap [s], with the rates [rad/s] and accelerations [m/s^2] that drive
/// them.
struct Step {
  double dt;
  Vector3d first, second;
};

std::vector<Step> steps(Generator& generator) {
  std::vector<Step> out = {{0.01, Vector3d::Zero(), Vector3d::Zero()},
                           {0.01, Vector3d::Constant(1e-8), Vector3d(0.0, 0.0, kGravity)}};
  for (const double dt : {1e-6, 0.005, 0.01, 0.1, 0.5}) {
    for (int k = 0; k < 4; ++k) {
      out.push_back({dt, random_vector(generator, 2.0), random_vector(generator, 15.0)});
    }
  }
  return out;
}

/// The error that `predict` makes of the error `dx` before it.
template <typename Predict>
VectorXd carried(const NavigationState& state, MotionModel motion, const VectorXd& dx, Predict&& predict) {
  NavigationState reference = state;
  predict(reference);
  NavigationState disturbed = retracted(state, motion, dx);
  predict(disturbed);
  return error_between(disturbed, reference, motion);
}

/// `predict(state, step)` against central differences, over all steps.
template <typename Predict>
void check_phi(std::uint64_t seed, MotionModel motion, Predict&& predict) {
  Generator generator(seed);
  for (const Step& step : steps(generator)) {
    NavigationState state = random_navigation_state(generator);
    state.omega_body = step.first;  // part of the state without an IMU
    const auto by_step = [&](NavigationState& s) { return predict(s, step); };
    NavigationState advanced = state;
    check_jacobian(
        by_step(advanced).Phi, [&](const VectorXd& dx) { return carried(state, motion, dx, by_step); }, 1e-7);
  }
}

TEST(PredictImu, PhiMatchesCentralDifferences) {
  check_phi(1, MotionModel::kImu, [](NavigationState& s, const Step& step) {
    return predict_imu(s, step.first, step.second, step.dt, ImuNoise{}, kGravity);
  });
}

TEST(PredictConstantVelocity, PhiMatchesCentralDifferences) {
  check_phi(2, MotionModel::kConstantVelocity, [](NavigationState& s, const Step& step) {
    return predict_constant_velocity(s, step.dt, ConstantVelocityNoise{});
  });
}

TEST(PredictOdometry, PhiMatchesCentralDifferences) {
  check_phi(3, MotionModel::kOdometry, [](NavigationState& s, const Step& step) {
    return predict_odometry(s, step.second, step.first, step.dt, OdometryNoise{});
  });
}

TEST(PredictOdometry, QIsTheNoiseOfTheInputsThroughTheirNumericJacobian) {
  Generator generator(4);
  OdometryNoise noise;
  noise.sigma_v << 0.1, 0.2, 0.3;
  noise.sigma_omega << 0.01, 0.02, 0.03;
  VectorXd sigma(6);
  sigma << noise.sigma_v, noise.sigma_omega;
  for (const Step& step : steps(generator)) {
    const NavigationState state = random_navigation_state(generator);
    const auto moved = [&](const VectorXd& d) {
      NavigationState s = state;
      (void)predict_odometry(s, step.second + d.head<3>(), step.first + d.tail<3>(), step.dt, noise);
      return s;
    };
    const NavigationState reference = moved(VectorXd::Zero(6));
    MatrixXd G(6, 6);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const VectorXd d = 1e-5 * VectorXd::Unit(6, k);
      G.col(k) = (error_between(moved(d), reference, MotionModel::kOdometry) -
                  error_between(moved(-d), reference, MotionModel::kOdometry)) /
                 2e-5;
    }
    NavigationState advanced = state;
    const MatrixXd Q = predict_odometry(advanced, step.second, step.first, step.dt, noise).Q;
    const MatrixXd expected = G * sigma.cwiseAbs2().asDiagonal() * G.transpose();
    const double tolerance = step.dt < 1e-3 ? 1e-3 : 1e-6;  // differences of a tiny step are coarse
    EXPECT_LE((Q - expected).cwiseAbs().maxCoeff(), tolerance * expected.cwiseAbs().maxCoeff()) << step.dt;
  }
}

/// White noise of density n, averaged over dt, has variance n²/dt: held over a step it gives Q but for the
/// position, whose dt³/3 becomes dt³/4, and for what the turn within the step does.
TEST(PredictImu, QIsTheNoiseOfTheInputsThroughTheirNumericJacobian) {
  Generator generator(5);
  const double dt = 0.005;
  ImuNoise noise;
  noise.gyro_density = 0.02;
  noise.accel_density = 0.3;
  noise.gyro_walk = noise.accel_walk = 0.0;
  for (int k = 0; k < 10; ++k) {
    const NavigationState state = random_navigation_state(generator);
    const Vector3d omega = random_vector(generator, 0.5);
    const Vector3d accel = random_vector(generator, 5.0);
    const auto moved = [&](const VectorXd& d) {
      NavigationState s = state;
      (void)predict_imu(s, omega + d.head<3>(), accel + d.tail<3>(), dt, noise, kGravity);
      return s;
    };
    const NavigationState reference = moved(VectorXd::Zero(6));
    MatrixXd G(15, 6);
    for (Eigen::Index i = 0; i < 6; ++i) {
      const VectorXd d = 1e-4 * VectorXd::Unit(6, i);
      G.col(i) = (error_between(moved(d), reference, MotionModel::kImu) -
                  error_between(moved(-d), reference, MotionModel::kImu)) /
                 2e-4;
    }
    VectorXd sigma(6);
    sigma << Vector3d::Constant(noise.gyro_density), Vector3d::Constant(noise.accel_density);
    sigma /= std::sqrt(dt);
    MatrixXd expected = G * sigma.cwiseAbs2().asDiagonal() * G.transpose();
    expected.topLeftCorner<3, 3>() *= 4.0 / 3.0;
    NavigationState advanced = state;
    const MatrixXd Q = predict_imu(advanced, omega, accel, dt, noise, kGravity).Q;
    const VectorXd scale = Q.diagonal().cwiseSqrt().cwiseMax(1e-12).cwiseInverse();
    const MatrixXd difference = scale.asDiagonal() * (Q - expected) * scale.asDiagonal();
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 2e-3);
  }
}

TEST(PredictImu, BiasesWalkAtTheirDensities) {
  NavigationState state;
  const ImuNoise noise;
  const double dt = 0.02;
  const MatrixXd Q = predict_imu(state, Vector3d::Zero(), Vector3d::Zero(), dt, noise, kGravity).Q;
  EXPECT_DOUBLE_EQ(Q(9, 9), noise.gyro_walk * noise.gyro_walk * dt);
  EXPECT_DOUBLE_EQ(Q(14, 14), noise.accel_walk * noise.accel_walk * dt);
}

TEST(PredictImu, OnlyInputsMinusBiasesMatter) {
  Generator generator(6);
  NavigationState biased = random_navigation_state(generator);
  NavigationState clean = biased;
  clean.bias_gyro.setZero();
  clean.bias_accel.setZero();
  const Vector3d omega = random_vector(generator, 1.0);
  const Vector3d accel = random_vector(generator, 10.0);
  (void)predict_imu(biased, omega + biased.bias_gyro, accel + biased.bias_accel, 0.1, ImuNoise{}, kGravity);
  (void)predict_imu(clean, omega, accel, 0.1, ImuNoise{}, kGravity);
  EXPECT_LE((biased.T_world_body.p - clean.T_world_body.p).norm(), 1e-14);
  EXPECT_LE((biased.T_world_body.R - clean.T_world_body.R).norm(), 1e-14);
  EXPECT_LE((biased.v_world_body - clean.v_world_body).norm(), 1e-14);
}

TEST(PredictImu, ABodyThatFeelsNothingFalls) {
  NavigationState state;
  for (int k = 0; k < 100; ++k) {
    (void)predict_imu(state, Vector3d::Zero(), Vector3d::Zero(), 0.01, ImuNoise{}, kGravity);
  }
  EXPECT_LE((state.v_world_body - Vector3d(0.0, 0.0, -kGravity)).norm(), 1e-12);
  EXPECT_LE((state.T_world_body.p - Vector3d(0.0, 0.0, -0.5 * kGravity)).norm(), 1e-12);
}

TEST(PredictImu, ASpinningTopStaysWhereItIsAndTurns) {
  NavigationState state;
  for (int k = 0; k < 100; ++k) {
    (void)predict_imu(state, Vector3d(0.0, 0.0, 1.5), Vector3d(0.0, 0.0, kGravity), 0.01, ImuNoise{},
                      kGravity);
  }
  EXPECT_LE(state.T_world_body.p.norm(), 1e-12);
  EXPECT_LE((state.T_world_body.R - so3_exp(Vector3d(0.0, 0.0, 1.5))).norm(), 1e-12);
}

/// Distance from the true position after a second on a circle (radius 2 m, 1 rad/s), in `count` steps.
double circle_error(int count) {
  const double radius = 2.0;
  NavigationState state;
  state.T_world_body.p << radius, 0.0, 0.0;
  state.v_world_body << 0.0, radius, 0.0;
  for (int k = 0; k < count; ++k) {
    (void)predict_imu(state, Vector3d::UnitZ(), Vector3d(-radius, 0.0, kGravity), 1.0 / count, ImuNoise{},
                      kGravity);
  }
  return (state.T_world_body.p - radius * Vector3d(std::cos(1.0), std::sin(1.0), 0.0)).norm();
}

TEST(PredictImu, ErrorOnACircleFallsWithTheSquareOfTheStep) {
  EXPECT_LE(circle_error(100), 1e-4);
  EXPECT_NEAR(circle_error(50) / circle_error(100), 4.0, 0.1);
  EXPECT_NEAR(circle_error(100) / circle_error(200), 4.0, 0.1);
}

TEST(PredictConstantVelocity, MovesOnAScrew) {
  NavigationState state;
  state.v_world_body << 1.0, -2.0, 0.5;
  state.omega_body << 0.1, 0.2, -0.3;
  for (int k = 0; k < 10; ++k) {
    (void)predict_constant_velocity(state, 0.1, ConstantVelocityNoise{});
  }
  EXPECT_LE((state.T_world_body.p - Vector3d(1.0, -2.0, 0.5)).norm(), 1e-13);
  EXPECT_LE((state.T_world_body.R - so3_exp(Vector3d(0.1, 0.2, -0.3))).norm(), 1e-13);
}

TEST(PredictOdometry, ClosesACircle) {
  NavigationState state;
  for (int k = 0; k < 1000; ++k) {
    (void)predict_odometry(state, Vector3d(1.0, 0.0, 0.0), Vector3d(0.0, 0.0, 2.0 * M_PI), 1e-3,
                           OdometryNoise{});
  }
  EXPECT_LE(state.T_world_body.p.norm(), 1e-10);
  EXPECT_LE((state.T_world_body.R - Eigen::Matrix3d::Identity()).norm(), 1e-10);
  EXPECT_LE((state.v_world_body - Vector3d::UnitX()).norm(), 1e-10);
}

/// Two steps as one.
Transition chained(const Transition& first, const Transition& second) {
  return {second.Phi * first.Phi, congruence(second.Phi, first.Q) + second.Q};
}

/// Largest difference of two steps, Q in units of its own standard deviations.
void expect_close(const Transition& a, const Transition& b, double tolerance) {
  EXPECT_LE((a.Phi - b.Phi).cwiseAbs().maxCoeff(), tolerance);
  const VectorXd scale = a.Q.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd difference = scale.asDiagonal() * (a.Q - b.Q) * scale.asDiagonal();
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), tolerance);
}

TEST(PredictImu, TwoHalfStepsAreNearlyOneStep) {
  Generator generator(7);
  ImuNoise noise;
  for (int k = 0; k < 10; ++k) {
    NavigationState whole = random_navigation_state(generator);
    NavigationState halves = whole;
    const Vector3d omega = random_vector(generator, 1.0);
    const Vector3d accel = random_vector(generator, 10.0);
    const Transition one = predict_imu(whole, omega, accel, 0.01, noise, kGravity);
    const Transition a = predict_imu(halves, omega, accel, 0.005, noise, kGravity);
    const Transition b = predict_imu(halves, omega, accel, 0.005, noise, kGravity);
    expect_close(one, chained(a, b), 2e-2);
    EXPECT_LE((one.Phi - b.Phi * a.Phi).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_LE(error_between(halves, whole, MotionModel::kImu).norm(), 1e-5);
  }
}

TEST(PredictConstantVelocity, TwoHalfStepsAreOneStep) {
  Generator generator(8);
  for (int k = 0; k < 10; ++k) {
    NavigationState whole = random_navigation_state(generator);
    NavigationState halves = whole;
    const Transition one = predict_constant_velocity(whole, 0.05, ConstantVelocityNoise{});
    const Transition a = predict_constant_velocity(halves, 0.025, ConstantVelocityNoise{});
    const Transition b = predict_constant_velocity(halves, 0.025, ConstantVelocityNoise{});
    expect_close(one, chained(a, b), 0.1);  // Q leaves out the turn within the step
    EXPECT_LE((one.Phi - b.Phi * a.Phi).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LE(error_between(halves, whole, MotionModel::kConstantVelocity).norm(), 1e-13);
  }
}

}  // namespace
}  // namespace limber
