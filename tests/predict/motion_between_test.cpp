// SPDX-License-Identifier: MIT
#include "limber/predict/motion_between.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <vector>

#include "check_covariance.hpp"
#include "check_jacobian.hpp"
#include "predict/navigation_error.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::error_between;
using testing::Generator;
using testing::random_navigation_state;
using testing::random_normal;
using testing::random_vector;
using testing::retracted;

constexpr double kDt = 0.005;
constexpr double kStandardGravity = 9.81;
constexpr MotionModel kModels[] = {MotionModel::kImu, MotionModel::kOdometry, MotionModel::kConstantVelocity};

std::vector<InputStep> random_steps(Generator& generator, int count) {
  std::vector<InputStep> out;
  for (int k = 0; k < count; ++k) {
    out.push_back({0, kDt, random_vector(generator, 1.0), random_vector(generator, 3.0), 1.0});
  }
  return out;
}

MotionBetween between(MotionModel motion, const std::vector<InputStep>& steps, const NavigationState& from,
                      const MotionNoise& noise = {}) {
  return motion_between(motion, kDt * static_cast<double>(steps.size()), steps, from, noise, kDt, 9.81);
}

/// The filter's own prediction over the same steps.
NavigationState predicted(MotionModel motion, const std::vector<InputStep>& steps, NavigationState state) {
  for (const InputStep& step : steps) {
    switch (motion) {
      case MotionModel::kImu:
        (void)predict_imu(state, step.angular, step.linear, step.dt, {}, kStandardGravity);
        break;
      case MotionModel::kOdometry:
        (void)predict_odometry(state, step.linear, step.angular, step.dt, {});
        break;
      case MotionModel::kConstantVelocity:
        (void)predict_constant_velocity(state, step.dt, {});
        break;
    }
  }
  return state;
}

TEST(MotionBetween, AgreesWithTheFiltersPrediction) {
  Generator generator(3);
  for (const MotionModel motion : kModels) {
    const NavigationState from = random_navigation_state(generator);
    const auto steps = random_steps(generator, 20);
    const MotionError error =
        motion_error(between(motion, steps, from), from, predicted(motion, steps, from), kStandardGravity);
    EXPECT_LT(error.error.cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(MotionBetween, FollowsOtherBiasesToFirstOrder) {
  Generator generator(4);
  const NavigationState from = random_navigation_state(generator);
  const auto steps = random_steps(generator, 20);
  const MotionBetween summed = between(MotionModel::kImu, steps, from);
  const auto error_with = [&](double size) {
    NavigationState other = from;
    other.bias_gyro += size * Vector3d(1.0, -0.5, 0.7);
    other.bias_accel += size * Vector3d(-0.3, 1.0, 0.4);
    return motion_error(summed, other, predicted(MotionModel::kImu, steps, other), kStandardGravity)
        .error.norm();
  };
  EXPECT_LT(error_with(1e-3), 1e-7);
  EXPECT_NEAR(error_with(2e-2) / error_with(1e-2), 4.0, 0.1);  // what is left is of second order
}

TEST(MotionBetween, DerivativesMeetCentralDifferences) {
  Generator generator(5);
  for (const MotionModel motion : kModels) {
    const NavigationState from = random_navigation_state(generator);
    const auto steps = random_steps(generator, 10);
    NavigationState biases = from;
    biases.bias_gyro += random_vector(generator, 0.05);
    const MotionBetween summed = between(motion, steps, biases);
    const Eigen::Index n = StateLayout{motion}.body_size();
    const NavigationState to =
        retracted(predicted(motion, steps, from), motion, 0.1 * random_normal(generator, n));
    const MotionError error = motion_error(summed, from, to, kStandardGravity);
    testing::check_jacobian(error.J_from, [&](const VectorXd& d) {
      return motion_error(summed, retracted(from, motion, d), to, kStandardGravity).error;
    });
    testing::check_jacobian(error.J_to, [&](const VectorXd& d) {
      return motion_error(summed, from, retracted(to, motion, d), kStandardGravity).error;
    });
  }
}

TEST(MotionBetween, CovarianceIsThatOfManyNoisyRuns) {
  Generator generator(6);
  MotionNoise noise;
  noise.imu = {0.002, 0.01, 0.03, 0.1};
  const auto steps = random_steps(generator, 40);
  NavigationState start;
  start.v_world_body = Vector3d(1.0, 2.0, 3.0);
  const MotionBetween summed = between(MotionModel::kImu, steps, start, noise);
  testing::SampleCovariance errors(15);
  const double per_sample = 1.0 / std::sqrt(kDt), per_step = std::sqrt(kDt);
  for (int run = 0; run < 6000; ++run) {
    NavigationState truth = start;  // moves without noise; what is measured is noisy and biased
    std::vector<InputStep> measured = steps;
    for (std::size_t k = 0; k < steps.size(); ++k) {
      const NavigationState unbiased = [&] {
        NavigationState s = truth;
        s.bias_gyro.setZero();
        s.bias_accel.setZero();
        return s;
      }();
      measured[k].angular +=
          truth.bias_gyro + per_sample * noise.imu.gyro_density * random_normal(generator, 3);
      measured[k].linear +=
          truth.bias_accel + per_sample * noise.imu.accel_density * random_normal(generator, 3);
      NavigationState next = unbiased;
      (void)predict_imu(next, steps[k].angular, steps[k].linear, kDt, {}, kStandardGravity);
      next.bias_gyro = truth.bias_gyro + per_step * noise.imu.gyro_walk * random_normal(generator, 3);
      next.bias_accel = truth.bias_accel + per_step * noise.imu.accel_walk * random_normal(generator, 3);
      truth = next;
    }
    errors.add(
        motion_error(between(MotionModel::kImu, measured, start, noise), start, truth, kStandardGravity)
            .error);
  }
  // Finite steps: the position's noise within a step is known to that accuracy only.
  errors.expect(summed.Q, 0.03);
}

}  // namespace
}  // namespace limber
