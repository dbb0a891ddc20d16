// SPDX-License-Identifier: MIT
#include "limber/diagnose/pose_loss.hpp"

#include <Eigen/Geometry>
#include <numbers>
#include <vector>

#include "limber/evaluate/evaluation.hpp"

namespace limber {

std::optional<PoseLoss> pose_loss(std::span<const StampedPose> trusting, std::span<const StampedPose> blind) {
  constexpr std::size_t kFewest = 10;
  constexpr double kShortest = 1.0;  // [m]
  const std::vector<MatchedPose> poses = match_by_time(trusting, blind);
  if (poses.size() < kFewest) {
    return std::nullopt;
  }
  const TrajectoryEvaluation evaluation = evaluate_trajectory(poses);
  if (evaluation.path_length < kShortest) {
    return std::nullopt;
  }
  const Pose first = poses.front().truth * poses.front().estimate.inverse();
  const Pose last = first * poses.back().estimate;
  PoseLoss out;
  out.path_m = evaluation.path_length;
  out.scale = evaluation.path_length_estimate / evaluation.path_length;
  out.drift_per_100_m = 100.0 * (last.p - poses.back().truth.p).norm() / evaluation.path_length;
  out.turn_deg =
      Eigen::AngleAxisd(last.R.transpose() * poses.back().truth.R).angle() * 180.0 / std::numbers::pi;
  return out;
}

}  // namespace limber
