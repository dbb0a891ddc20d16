// SPDX-License-Identifier: MIT
#include "limber/datasets/interpolate.hpp"

#include <algorithm>
#include <stdexcept>

#include "limber/core/pose.hpp"

namespace limber {

std::optional<GroundTruthState> groundtruth_at(const std::vector<GroundTruthState>& states, std::int64_t t_ns,
                                               std::int64_t max_gap_ns) {
  if (states.empty()) {
    return std::nullopt;
  }
  const auto after = std::lower_bound(states.begin(), states.end(), t_ns,
                                      [](const GroundTruthState& s, std::int64_t t) { return s.t_ns < t; });
  if (after != states.end() && after->t_ns == t_ns) {
    return *after;
  }
  // The two samples around t, at the ends the outermost two; a lone sample is its own neighbour.
  const std::ptrdiff_t neighbours = states.size() > 1 ? 1 : 0;
  const auto b = std::clamp(after, states.begin() + neighbours, states.end() - 1);
  const auto a = b - neighbours;
  if (std::min(std::abs(t_ns - a->t_ns), std::abs(b->t_ns - t_ns)) > max_gap_ns) {
    return std::nullopt;
  }
  const double s =
      a == b ? 0.0 : static_cast<double>(t_ns - a->t_ns) / static_cast<double>(b->t_ns - a->t_ns);
  const auto linear = [s](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return Eigen::Vector3d((1.0 - s) * from + s * to);
  };
  const Pose pose = interpolate({a->R_world_body, a->p_world_body}, {b->R_world_body, b->p_world_body}, s);
  GroundTruthState state;
  state.t_ns = t_ns;
  state.R_world_body = pose.R;
  state.p_world_body = pose.p;
  state.v_world_body = linear(a->v_world_body, b->v_world_body);
  state.bias_gyro = linear(a->bias_gyro, b->bias_gyro);
  state.bias_accel = linear(a->bias_accel, b->bias_accel);
  return state;
}

TrueRig true_rig_at(const std::vector<TrueRig>& truth, std::int64_t t_ns) {
  if (truth.empty()) {
    throw std::invalid_argument("true_rig_at: no sample of the true calibration");
  }
  const auto after = std::upper_bound(truth.begin(), truth.end(), t_ns,
                                      [](std::int64_t t, const TrueRig& c) { return t < c.t_ns; });
  return {t_ns, (after == truth.begin() ? after : after - 1)->theta};
}

}  // namespace limber
