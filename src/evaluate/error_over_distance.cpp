// SPDX-License-Identifier: MIT
#include "limber/evaluate/error_over_distance.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "limber/core/median.hpp"
#include "limber/evaluate/trajectory_error.hpp"

namespace limber {
namespace {

constexpr double kShortestShare = 0.01, kLongestShare = 0.5;  // of the path

ErrorSpread spread_of(const std::vector<double>& values) {
  return {statistics_of(values).mean, quantile(values, 0.25), quantile(values, 0.5), quantile(values, 0.75)};
}

}  // namespace

std::vector<double> round_distances(std::span<const MatchedPose> poses) {
  const double length = true_path_length(poses);
  std::vector<double> out;
  if (!(length > 0.0)) {
    return out;
  }
  for (double decade = std::pow(10.0, std::floor(std::log10(kShortestShare * length)));
       decade <= kLongestShare * length; decade *= 10.0) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double distance = digit * decade;
      if (distance >= kShortestShare * length && distance <= kLongestShare * length) {
        out.push_back(distance);
      }
    }
  }
  return out;
}

std::vector<ErrorOverDistance> errors_over_distances(std::span<const MatchedPose> poses,
                                                     std::span<const double> distances,
                                                     double relative_tolerance) {
  std::vector<ErrorOverDistance> out;
  for (const double distance : distances) {
    const std::vector<IndexPair> pairs = pairs_by_path(poses, distance, relative_tolerance);
    if (pairs.empty()) {
      continue;
    }
    std::vector<double> percent, degrees;
    for (const RelativeError& error : relative_errors_of(poses, pairs)) {
      percent.push_back(100.0 * error.position_m / distance);
      degrees.push_back(error.attitude_deg);
    }
    out.push_back({distance, pairs.size(), spread_of(percent), spread_of(degrees)});
  }
  return out;
}

}  // namespace limber
