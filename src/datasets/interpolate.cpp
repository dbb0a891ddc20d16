// SPDX-License-Identifier: MIT
#include "limber/datasets/interpolate.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "limber/core/so3.hpp"

namespace limber {

std::optional<GroundTruthState> groundtruth_at(const std::vector<GroundTruthState>& states, std::int64_t t_ns,
                                               std::int64_t max_gap_ns) {
  if (states.empty()) {
    return std::nullopt;
  }
  const auto after = std::lower_bound(states.begin(), states.end(), t_ns,
                                      [](const GroundTruthState& s, std::int64_t t) { return s.t_ns < t; });
  const GroundTruthState& b = after == states.end() ? states.back() : *after;
  const GroundTruthState& a = after == states.begin() || b.t_ns == t_ns ? b : *(after - 1);
  if (std::min(std::abs(t_ns - a.t_ns), std::abs(b.t_ns - t_ns)) > max_gap_ns) {
    return std::nullopt;
  }
  // a and b are the same before the first, after the last and at a sample.
  const double s = &a == &b ? 0.0 : static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  const auto linear = [s](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return Eigen::Vector3d((1.0 - s) * from + s * to);
  };
  GroundTruthState state = a;
  state.t_ns = t_ns;
  state.R_world_body = a.R_world_body * so3_exp(s * so3_log(a.R_world_body.transpose() * b.R_world_body));
  state.p_world_body = linear(a.p_world_body, b.p_world_body);
  state.v_world_body = linear(a.v_world_body, b.v_world_body);
  state.bias_gyro = linear(a.bias_gyro, b.bias_gyro);
  state.bias_accel = linear(a.bias_accel, b.bias_accel);
  return state;
}

RigParameters calibration_at(const std::vector<CalibrationTruth>& truth, std::int64_t t_ns) {
  if (truth.empty()) {
    throw std::invalid_argument("calibration_at: no sample of the true calibration");
  }
  const auto after = std::upper_bound(truth.begin(), truth.end(), t_ns,
                                      [](std::int64_t t, const CalibrationTruth& c) { return t < c.t_ns; });
  return (after == truth.begin() ? after : after - 1)->theta;
}

}  // namespace limber
