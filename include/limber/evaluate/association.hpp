// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "limber/core/pose.hpp"

namespace limber {

/// An estimated pose and the truth at the same time, both `T_world_body`.
struct MatchedPose {
  /// [ns], of the estimate
  std::int64_t t_ns = 0;
  std::size_t index = 0;  ///< of the estimate in the list it came from
  /// T_world_body in the world of the estimate
  Pose estimate;
  /// T_world_body in the world of the truth, at the same time
  Pose truth;
};

/// How far [s] the nearest ground truth sample may be from an estimate.
inline constexpr double kMaxTimeDifference = 0.01;

/// @brief Ground truth at the times of the estimate.
/// The truth is interpolated between its samples (linearly, slerp), and continued with the motion of its
/// outermost two where the estimate starts or ends up to `max_time_difference` [s] outside. Both lists in
/// strictly increasing time.
/// @return the estimates with a ground truth sample at most `max_time_difference` away, in order; may be
/// empty
/// @throws std::invalid_argument if times do not increase, a pose is not finite, or max_time_difference < 0
[[nodiscard]] std::vector<MatchedPose> match_by_time(std::span<const StampedPose> estimate,
                                                     std::span<const StampedPose> truth,
                                                     double max_time_difference = kMaxTimeDifference);

/// @brief The n-th estimate with the n-th truth, for files without times (KITTI). Times are those of the
/// estimate.
/// @throws std::invalid_argument if the lists differ in length, or a pose is not finite
[[nodiscard]] std::vector<MatchedPose> match_by_index(std::span<const StampedPose> estimate,
                                                      std::span<const StampedPose> truth);

}  // namespace limber
