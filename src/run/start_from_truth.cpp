// SPDX-License-Identifier: MIT
#include "start_from_truth.hpp"

#include <algorithm>

#include "limber/core/time.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/run/draw_initial_state.hpp"

namespace limber::detail {
namespace {

constexpr double kUnknownBiasGyro = 0.1;   // [rad/s], truth without biases
constexpr double kUnknownBiasAccel = 0.2;  // [m/s^2]
constexpr double kUnknownVelocity = 0.1;   // [m/s], truth without velocity: differences

/// Velocity of a truth that does not give it.
Eigen::Vector3d differenced_velocity(const Recording& recording, std::int64_t t_ns) {
  const auto& truth = recording.truth.motion.states;
  const auto it = std::lower_bound(truth.begin(), truth.end(), t_ns,
                                   [](const GroundTruthState& s, std::int64_t t) { return s.t_ns < t; });
  const std::size_t k = std::min<std::size_t>(static_cast<std::size_t>(it - truth.begin()), truth.size() - 1);
  const GroundTruthState& a = truth[k > 0 ? k - 1 : 0];
  const GroundTruthState& b = truth[std::min(k + 1, truth.size() - 1)];
  return a.t_ns == b.t_ns
             ? Eigen::Vector3d::Zero()
             : Eigen::Vector3d((b.p_world_body - a.p_world_body) / seconds_between(a.t_ns, b.t_ns));
}

}  // namespace

InitialState start_from_truth(const Recording& recording, const RunOptions& options, const RunSetup& setup,
                              std::int64_t t_ns) {
  GroundTruthState truth = *groundtruth_at(recording.truth.motion.states, t_ns);
  InitialSigma sigma = options.initial;
  InitialSigma error = options.initial_error.value_or(options.initial);
  if (!recording.truth.motion.has_velocity) {
    truth.v_world_body = differenced_velocity(recording, t_ns);
    sigma.velocity = std::max(sigma.velocity, kUnknownVelocity);
    error.velocity = std::max(error.velocity, kUnknownVelocity);
  }
  InitialSigma drawn = error;
  if (!recording.truth.motion.has_biases) {
    drawn.bias_accel = drawn.bias_gyro = 0.0;
    sigma.bias_accel = std::max(sigma.bias_accel, kUnknownBiasAccel);
    sigma.bias_gyro = std::max(sigma.bias_gyro, kUnknownBiasGyro);
  }
  const GroundTruthState start = draw_initial_state(truth, drawn, options.seed, options.run);
  NavigationState nav;
  nav.t_ns = t_ns;
  nav.T_world_body = {start.R_world_body, start.p_world_body};
  nav.v_world_body = start.v_world_body;
  nav.bias_gyro = start.bias_gyro;
  nav.bias_accel = start.bias_accel;
  sigma.rate = 0.5;  // the truth gives no rate
  return make_initial_state(nav, setup.navigator.motion, sigma);
}

}  // namespace limber::detail
