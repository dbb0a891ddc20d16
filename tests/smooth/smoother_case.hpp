// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "check_covariance.hpp"
#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/run/draw_initial_state.hpp"
#include "limber/run/rig_parts.hpp"
#include "limber/simulate/simulator.hpp"
#include "limber/smooth/smoother.hpp"

/// A small recording for the smoothers, with its truth.
namespace limber::testing {

inline constexpr double kFalseAlarm = 1e-4;

/// Two seconds of a drone's rig in a small map; few points, so that it is quick.
inline Scenario small_scenario() {
  Scenario scenario;
  scenario.name = "small";
  scenario.duration = 2.0;
  scenario.stereo_rate = 10.0;
  scenario.world.points = 60;
  scenario.rig.theta << 0.0, 0.0, 0.0, -0.5, 0.0, 0.0;
  scenario.odometry = OdometryScenario{};
  scenario.noise.accel_walk = 0.01;
  scenario.noise.gyro_walk = 1e-3;
  return scenario;
}

inline const RigParameters kBent = (RigParameters() << 0.004, -0.006, 0.003, 0.02, -0.01, 0.01).finished();

inline NavigationState state_of(const GroundTruthState& truth) {
  NavigationState out;
  out.t_ns = truth.t_ns;
  out.T_world_body = {truth.R_world_body, truth.p_world_body};
  out.v_world_body = truth.v_world_body;
  out.bias_gyro = truth.bias_gyro;
  out.bias_accel = truth.bias_accel;
  return out;
}

/// A recording with a start that is wrong, and the prior that its first state was drawn from.
struct Case {
  explicit Case(const Scenario& scenario, MotionModel motion, std::uint64_t run)
      : recording(simulate(scenario, 7, run)) {
    Generator generator(run);
    options.motion = motion;
    options.noise.imu = *recording.imu_noise;
    options.noise.odometry = recording.odometry_noise.value_or(OdometryNoise{});
    options.sigma_px = *recording.pixel_noise;
    for (const StereoFrame& frame : recording.frames) {
      truth.push_back(state_of(*groundtruth_at(recording.truth.motion.states, frame.t_ns)));
      NavigationState state = truth.back();
      state.T_world_body.p += 0.05 * random_normal(generator, 3);
      state.T_world_body.R *= so3_exp(0.01 * random_normal(generator, 3));
      state.v_world_body += 0.1 * random_normal(generator, 3);
      state.bias_gyro.setZero();
      state.bias_accel.setZero();
      start.push_back(state);
    }
    const InitialSigma sigma;
    prior = make_initial_state(
        state_of(draw_initial_state(*groundtruth_at(recording.truth.motion.states, truth.front().t_ns), sigma,
                                    7, run)),
        motion, sigma);
  }

  [[nodiscard]] SmootherResult solve() const {
    return smooth({recording.frames, recording.imu, recording.odometry, start, prior}, recording.calibration,
                  options);
  }

  Recording recording;
  std::vector<NavigationState> truth, start;
  InitialState prior;
  SmootherOptions options;
};

inline Eigen::VectorXd pose_error(const NavigationState& truth, const NavigationState& estimate) {
  Eigen::VectorXd out(6);
  out << truth.T_world_body.p - estimate.T_world_body.p,
      so3_log(estimate.T_world_body.R.transpose() * truth.T_world_body.R);
  return out;
}

inline double nees(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.dot(Cholesky(covariance).solve(error));
}

/// Whether a sum of squares is what so many independent normal numbers add up to.
inline void expect_chi_square(double sum, double dof) {
  EXPECT_GT(sum, chi_square_quantile(kFalseAlarm, dof));
  EXPECT_LT(sum, chi_square_quantile(1.0 - kFalseAlarm, dof));
}

inline Scenario bent(Scenario scenario) {
  scenario.decalibration = {{kBent, ConstantShape{}}};
  return scenario;
}

}  // namespace limber::testing
