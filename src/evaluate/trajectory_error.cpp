// SPDX-License-Identifier: MIT
#include "limber/evaluate/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "limber/core/so3.hpp"

namespace limber {
namespace {

double angle_deg(const Eigen::Matrix3d& R) { return so3_log(R).norm() * 180.0 / std::numbers::pi; }

PoseErrorStatistics statistics_of_errors(const std::vector<double>& position_m,
                                         const std::vector<double>& attitude_deg) {
  return {statistics_of(position_m), statistics_of(attitude_deg)};
}

// Distance travelled from the first pose to each.
std::vector<double> travelled(std::span<const MatchedPose> poses, Pose MatchedPose::*which) {
  std::vector<double> distance(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    distance[i] = distance[i - 1] + ((poses[i].*which).p - (poses[i - 1].*which).p).norm();
  }
  return distance;
}

}  // namespace

PoseErrorStatistics absolute_errors(std::span<const MatchedPose> poses, const Alignment& alignment) {
  if (alignment.status != AlignmentStatus::kAligned) {
    throw std::invalid_argument("absolute errors: the alignment is not determined: " +
                                std::string(describe(alignment.status)));
  }
  std::vector<double> position_m, attitude_deg;
  for (const MatchedPose& pose : poses) {
    const Pose estimate = alignment * pose.estimate;
    position_m.push_back((pose.truth.p - estimate.p).norm());
    attitude_deg.push_back(angle_deg(estimate.R.transpose() * pose.truth.R));
  }
  return statistics_of_errors(position_m, attitude_deg);
}

std::vector<IndexPair> pairs_by_frames(std::size_t poses, std::size_t delta) {
  if (delta == 0) {
    throw std::invalid_argument("relative errors: the distance in frames must not be zero");
  }
  std::vector<IndexPair> pairs;
  for (std::size_t i = 0; i + delta < poses; ++i) {
    pairs.emplace_back(i, i + delta);
  }
  return pairs;
}

std::vector<IndexPair> pairs_by_path(std::span<const MatchedPose> poses, double distance,
                                     double relative_tolerance) {
  if (!(distance > 0.0) || !std::isfinite(distance) || !(relative_tolerance >= 0.0)) {
    throw std::invalid_argument(
        "relative errors: distance must be positive and tolerance not negative, got " +
        std::to_string(distance) + " m and " + std::to_string(relative_tolerance));
  }
  const std::vector<double> at = travelled(poses, &MatchedPose::estimate);
  std::vector<IndexPair> pairs;
  for (std::size_t i = 0; i + 1 < at.size(); ++i) {
    // The first of several poses in the same place, as a search from the front would find it.
    const auto first_beyond = [&](double d) {
      return std::partition_point(at.begin() + static_cast<std::ptrdiff_t>(i) + 1, at.end(),
                                  [&](double a) { return a - at[i] < d; });
    };
    const auto miss = [&](auto it) { return std::abs(*it - at[i] - distance); };
    auto nearest = first_beyond(distance);
    if (nearest != at.begin() + static_cast<std::ptrdiff_t>(i) + 1) {
      const auto before = first_beyond(*(nearest - 1) - at[i]);
      nearest = nearest == at.end() || miss(before) <= miss(nearest) ? before : nearest;
    }
    if (miss(nearest) <= relative_tolerance * distance) {
      pairs.emplace_back(i, static_cast<std::size_t>(nearest - at.begin()));
    }
  }
  return pairs;
}

std::vector<IndexPair> disjoint_pieces(std::span<const MatchedPose> poses, double distance) {
  if (!(distance > 0.0) || !std::isfinite(distance)) {
    throw std::invalid_argument("pieces of a path: their length must be positive, got " +
                                std::to_string(distance) + " m");
  }
  const std::vector<double> at = travelled(poses, &MatchedPose::truth);
  std::vector<IndexPair> pieces;
  std::size_t begin = 0;
  for (std::size_t k = 1; k < at.size(); ++k) {
    if (at[k] - at[begin] >= distance) {
      pieces.emplace_back(begin, k);
      begin = k;
    }
  }
  return pieces;
}

std::vector<RelativeError> relative_errors_of(std::span<const MatchedPose> poses,
                                              std::span<const IndexPair> pairs) {
  std::vector<RelativeError> errors;
  errors.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    if (i >= poses.size() || j >= poses.size()) {
      throw std::invalid_argument("relative errors: pair (" + std::to_string(i) + ", " + std::to_string(j) +
                                  ") with " + std::to_string(poses.size()) + " poses");
    }
    const Pose true_step = poses[i].truth.inverse() * poses[j].truth;
    const Pose estimated_step = poses[i].estimate.inverse() * poses[j].estimate;
    const Pose error = true_step.inverse() * estimated_step;
    errors.push_back({error.p.norm(), angle_deg(error.R)});
  }
  return errors;
}

std::optional<PoseErrorStatistics> relative_errors(std::span<const MatchedPose> poses,
                                                   std::span<const IndexPair> pairs) {
  if (pairs.empty()) {
    return std::nullopt;
  }
  std::vector<double> position_m, attitude_deg;
  for (const RelativeError& error : relative_errors_of(poses, pairs)) {
    position_m.push_back(error.position_m);
    attitude_deg.push_back(error.attitude_deg);
  }
  return statistics_of_errors(position_m, attitude_deg);
}

double estimated_path_length(std::span<const MatchedPose> poses) {
  return poses.empty() ? 0.0 : travelled(poses, &MatchedPose::estimate).back();
}

double true_path_length(std::span<const MatchedPose> poses) {
  return poses.empty() ? 0.0 : travelled(poses, &MatchedPose::truth).back();
}

}  // namespace limber
