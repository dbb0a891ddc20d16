// SPDX-License-Identifier: MIT
#include "limber/evaluate/association.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace limber {
namespace {

void check_finite(std::span<const StampedPose> poses, const std::string& name) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose& pose = poses[i].T_world_body;
    if (!pose.R.allFinite() || !pose.p.allFinite()) {
      throw std::invalid_argument(name + ": pose " + std::to_string(i) + " is not finite");
    }
  }
}

void check_increasing(std::span<const StampedPose> poses, const std::string& name) {
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if (poses[i].t_ns <= poses[i - 1].t_ns) {
      throw std::invalid_argument(name + ": the time of pose " + std::to_string(i) + " does not increase (" +
                                  std::to_string(poses[i - 1].t_ns) + " ns, then " +
                                  std::to_string(poses[i].t_ns) + " ns)");
    }
  }
}

Pose pose_at(std::span<const StampedPose> poses, std::size_t nearest, std::int64_t t_ns) {
  if (poses[nearest].t_ns == t_ns || poses.size() == 1) {
    return poses[nearest].T_world_body;
  }
  const bool before_nearest = t_ns < poses[nearest].t_ns;
  std::size_t first = before_nearest && nearest > 0 ? nearest - 1 : nearest;
  first = std::min(first, poses.size() - 2);
  const StampedPose &a = poses[first], &b = poses[first + 1];
  const double s = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  return interpolate(a.T_world_body, b.T_world_body, s);
}

// Index of the pose whose time is nearest to t_ns, searched from `from` on.
std::size_t nearest_in_time(std::span<const StampedPose> poses, std::size_t from, std::int64_t t_ns) {
  std::size_t i = from;
  while (i + 1 < poses.size() && std::abs(poses[i + 1].t_ns - t_ns) <= std::abs(poses[i].t_ns - t_ns)) {
    ++i;
  }
  return i;
}

}  // namespace

std::vector<MatchedPose> match_by_time(std::span<const StampedPose> estimate,
                                       std::span<const StampedPose> truth, double max_time_difference) {
  if (!(max_time_difference >= 0.0)) {
    throw std::invalid_argument("matching in time: the largest difference must not be negative, got " +
                                std::to_string(max_time_difference) + " s");
  }
  check_finite(estimate, "estimate");
  check_finite(truth, "ground truth");
  check_increasing(estimate, "estimate");
  check_increasing(truth, "ground truth");

  std::vector<MatchedPose> matched;
  matched.reserve(truth.empty() ? 0 : estimate.size());
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < estimate.size() && !truth.empty(); ++i) {
    const std::int64_t t_ns = estimate[i].t_ns;
    nearest = nearest_in_time(truth, nearest, t_ns);
    const auto difference_ns = static_cast<double>(std::abs(truth[nearest].t_ns - t_ns));
    if (difference_ns <= max_time_difference * 1e9) {
      matched.push_back({t_ns, i, estimate[i].T_world_body, pose_at(truth, nearest, t_ns)});
    }
  }
  return matched;
}

std::vector<MatchedPose> match_by_index(std::span<const StampedPose> estimate,
                                        std::span<const StampedPose> truth) {
  if (estimate.size() != truth.size()) {
    throw std::invalid_argument("matching by index: the estimate has " + std::to_string(estimate.size()) +
                                " poses, the ground truth " + std::to_string(truth.size()));
  }
  check_finite(estimate, "estimate");
  check_finite(truth, "ground truth");
  std::vector<MatchedPose> matched;
  matched.reserve(estimate.size());
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    matched.push_back({estimate[i].t_ns, i, estimate[i].T_world_body, truth[i].T_world_body});
  }
  return matched;
}

}  // namespace limber
