// SPDX-License-Identifier: MIT
// The cameras' clock against that of the IMU; cam1's is in cam1_time_offset.cpp.
#include "limber/diagnose/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <vector>

#include "diagnose/clustered_regression.hpp"
#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"

namespace limber {
namespace {

using detail::ClusteredRows;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kEnoughPairs = 20;
constexpr int kShifts = 8;
constexpr double kAround = 0.15;  // length of what is before and behind a turn [s]
constexpr double kCluster = 1.0;  // [s]
constexpr std::size_t kEnoughClusters = 4;
constexpr double kLargestOffset = 1.0;  // [s]

/// Rows for (bias, a change of tau) at the present tau. The instrument of the gyro's slope is its slope over
/// a while before and behind: noise of the samples between is in both sides, and alone looks like
/// milliseconds. Turns that overlap, and the tracks that they see, share a cluster.
ClusteredRows gyro_rows(const std::vector<detail::Turn>& turns, const detail::GyroAttitude& gyro,
                        double tau) {
  ClusteredRows rows;
  const double sample = gyro.sample_time();
  for (const detail::Turn& turn : turns) {
    const double begin = turn.begin_s + tau, end = turn.end_s + tau;
    const auto mean = gyro.mean_rate(begin, end), first = gyro.rate(begin), last = gyro.rate(end);
    const auto before = gyro.mean_rate(begin - sample - kAround, begin - sample),
               behind = gyro.mean_rate(end + sample, end + sample + kAround);
    if (!mean || !first || !last || !before || !behind) {
      continue;
    }
    const Vector3d slope = (*last - *first) / (end - begin);
    const Vector3d around = (*behind - *before) / (end - begin + 2.0 * sample + kAround);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      VectorXd row = VectorXd::Zero(4);
      row(axis) = 1.0;
      row(3) = slope(axis);
      rows.A.push_back(row);
      row(3) = around(axis);
      rows.Z.push_back(row);
      rows.y.push_back(turn.rate(axis) - (*mean)(axis));
      rows.cluster.push_back(static_cast<std::int64_t>(turn.begin_s / kCluster));
    }
  }
  return rows;
}

}  // namespace

std::optional<TimeOffset> camera_time_offset(const StereoCalibration& calibration,
                                             std::span<const StereoFrame> frames,
                                             std::span<const ImuSample> imu) {
  if (calibration.body != BodyFrame::kImu || imu.size() < 2 || frames.size() < kEnoughPairs) {
    return std::nullopt;
  }
  const detail::GyroAttitude gyro(imu);
  const std::vector<detail::Turn> turns = detail::left_turns(calibration, frames, imu.front().t_ns);
  TimeOffset out;
  for (int i = 0; i < kShifts; ++i) {
    const ClusteredRows rows = gyro_rows(turns, gyro, out.seconds);
    const std::set<std::int64_t> clusters(rows.cluster.begin(), rows.cluster.end());
    if (rows.y.size() < 3 * kEnoughPairs || clusters.size() < kEnoughClusters) {
      return std::nullopt;
    }
    const auto solution = detail::solve(rows);
    if (!solution) {
      return std::nullopt;
    }
    out.seconds += solution->x(3);
    out.sigma = solution->sigma_of_last;
    out.dof = solution->dof;
    if (std::abs(out.seconds) > kLargestOffset) {
      return std::nullopt;
    }
  }
  return out;
}

}  // namespace limber
