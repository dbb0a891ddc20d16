// SPDX-License-Identifier: MIT
#include "limber/evaluate/evaluation.hpp"

#include <stdexcept>

#include "limber/core/time.hpp"

namespace limber {
namespace {

AlignedErrors aligned_errors(std::span<const MatchedPose> poses, AlignmentKind kind) {
  AlignedErrors result{align(poses, kind), std::nullopt};
  if (result.alignment.status == AlignmentStatus::kAligned) {
    result.errors = absolute_errors(poses, result.alignment);
  }
  return result;
}

}  // namespace

TrajectoryEvaluation evaluate_trajectory(std::span<const MatchedPose> poses,
                                         const RelativeErrorSettings& settings) {
  if (poses.empty()) {
    throw std::invalid_argument("evaluation: no pose has ground truth");
  }
  TrajectoryEvaluation result;
  result.poses = poses.size();
  result.duration = seconds_between(poses.front().t_ns, poses.back().t_ns);
  result.path_length = true_path_length(poses);
  result.path_length_estimate = estimated_path_length(poses);
  result.none = aligned_errors(poses, AlignmentKind::kNone);
  result.first_pose = aligned_errors(poses, AlignmentKind::kFirstPose);
  result.se3 = aligned_errors(poses, AlignmentKind::kSe3);
  result.sim3 = aligned_errors(poses, AlignmentKind::kSim3);
  result.relative_1_frame = relative_errors(poses, pairs_by_frames(poses.size(), 1));
  result.relative_distance =
      relative_errors(poses, pairs_by_path(poses, settings.distance, settings.relative_tolerance));
  return result;
}

}  // namespace limber
