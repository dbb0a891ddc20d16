// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "limber/datasets/recording.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// @brief Ground truth at `t_ns`: position, velocity and biases linear, attitude along the shortest rotation
/// (slerp).
/// @param states     strictly increasing time
/// @param max_gap_ns how far the nearest sample may be [ns]
/// @return the state with `t_ns` as its time; nothing if the nearest sample is further away than max_gap_ns.
///         Before the first and after the last sample, but within max_gap_ns, the motion between the
///         outermost two goes on (as in match_by_time); a lone sample is held.
[[nodiscard]] std::optional<GroundTruthState> groundtruth_at(const std::vector<GroundTruthState>& states,
                                                             std::int64_t t_ns,
                                                             std::int64_t max_gap_ns = 10'000'000);

/// @brief The true rig at `t_ns`: the latest sample at or before it, the first one before that. Not
/// interpolated, because that would smear a step of the rig over one interval.
/// @param truth strictly increasing time
/// @return with `t_ns` as its time
/// @throws std::invalid_argument if `truth` is empty
[[nodiscard]] TrueRig true_rig_at(const std::vector<TrueRig>& truth, std::int64_t t_ns);

}  // namespace limber
