// SPDX-License-Identifier: MIT
#include "limber/diagnose/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "diagnose/clustered_regression.hpp"
#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"
#include "limber/measure/epipolar.hpp"

namespace limber {
namespace {

using detail::ClusteredRows;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLongestBetween = 0.3;  // [s] between frames that follow each other
constexpr std::size_t kEnoughRows = 200, kEnoughPairs = 20;
constexpr int kShifts = 8;
constexpr double kAround = 0.15;  // length of what is before and behind a turn [s]
constexpr double kCluster = 1.0;  // [s]
constexpr std::size_t kEnoughClusters = 4;
/// The rig may be another one in the next piece: one that jumps or drifts while it moves looks like an offset
/// [s].
constexpr double kPiece = 4.0;
constexpr double kLargestOffset = 1.0;  // [s]

/// The five directions that stereo points alone can see: three angles of theta [rad], and the baseline's
/// direction [shares of its length]. Columns: turn and translation.
Eigen::Matrix<double, 6, 5> visible_directions(const RigParameters& theta) {
  const Vector3d t = theta.tail<3>();
  const Eigen::Matrix3d basis = householder_qr(t).Q();
  Eigen::Matrix<double, 6, 5> out = Eigen::Matrix<double, 6, 5>::Zero();
  out.leftCols<3>() = detail::pose_by_theta(theta).leftCols<3>();
  out.bottomRightCorner<3, 2>() = t.norm() * basis.rightCols<2>();
  return out;
}

using Followed = std::unordered_map<std::int64_t, StereoBearings>;

Followed followed(const StereoCalibration& calibration, const StereoFrame& frame) {
  Followed out;
  for (const StereoObservation& o : frame.observations) {
    if (const auto pair = detail::bearings(calibration, o)) {
      out[o.track_id] = *pair;
    }
  }
  return out;
}

/// Between where a point was a frame before and where it is a frame after.
StereoBearings between(const StereoBearings& before, const StereoBearings& after) {
  return {0.5 * (before.cam0 + after.cam0), 0.5 * (before.cam1 + after.cam1)};
}

/// Of a bearing (z = 1), along a direction in the image, for a pixel's variance of 1.
double bearing_variance(const Camera& camera, const Vector3d& bearing, const Eigen::Vector2d& along) {
  const auto projection = project(camera, bearing);
  if (!projection) {
    return std::numeric_limits<double>::infinity();
  }
  const Eigen::Matrix2d pixel_by_bearing = projection->J_uv_X.leftCols<2>();
  return (pixel_by_bearing.inverse().transpose() * along).squaredNorm();
}

/// Of the distance to the epipolar line, for pixels of variance 1: at the rim of a wide lens a pixel is worth
/// several in its middle.
double epipolar_variance(const StereoCalibration& calibration, const StereoBearings& pair,
                         const Vector3d& line) {
  const Eigen::Vector2d across = line.head<2>();
  return bearing_variance(calibration.cam0, pair.cam0, across) +
         bearing_variance(calibration.cam1, pair.cam1, across);
}

ClusteredRows epipolar_rows(const StereoCalibration& calibration, std::span<const StereoFrame> frames) {
  const Pose T_cam1_cam0 = pose_from_rig(calibration.theta);
  const Eigen::Matrix<double, 6, 5> visible = visible_directions(calibration.theta);
  const auto slope_at = [&](const StereoBearings& pair) -> VectorXd {
    VectorXd row(6);
    row.head<5>() = (detail::epipolar_slope(pair, T_cam1_cam0) * visible).transpose();
    return row;
  };
  ClusteredRows rows;
  Followed before = followed(calibration, frames[0]), now = followed(calibration, frames[1]);
  for (std::size_t n = 1; n + 1 < frames.size(); ++n) {
    Followed after = followed(calibration, frames[n + 1]);
    const double dt = seconds_between(frames[n - 1].t_ns, frames[n + 1].t_ns);
    for (const auto& [id, pair] : now) {
      const auto a = before.find(id), b = after.find(id);
      if (a == before.end() || b == after.end() || dt > 2.0 * kLongestBetween) {
        continue;
      }
      VectorXd row = slope_at(pair);
      row(5) = detail::epipolar_line(pair.cam0, T_cam1_cam0).dot(b->second.cam1 - a->second.cam1) / dt;
      // Without the noise of this frame, which is in the residual.
      const StereoBearings beside = between(a->second, b->second);
      const Vector3d line = detail::epipolar_line(beside.cam0, T_cam1_cam0);
      VectorXd instrument = slope_at(beside);
      instrument(5) = line.dot(T_cam1_cam0.R * (b->second.cam0 - a->second.cam0)) / dt;
      const double weight = 1.0 / std::sqrt(epipolar_variance(calibration, beside, line));
      rows.A.emplace_back(weight * row);
      rows.Z.emplace_back(weight * instrument);
      rows.y.push_back(weight * detail::epipolar_error(pair, T_cam1_cam0));
      rows.cluster.push_back(id);
    }
    before = std::move(now);
    now = std::move(after);
  }
  return rows;
}

/// With one rig for all of the frames.
std::optional<TimeOffset> offset_of_piece(const StereoCalibration& calibration,
                                          std::span<const StereoFrame> frames) {
  if (frames.size() < 3) {
    return std::nullopt;
  }
  const ClusteredRows rows = epipolar_rows(calibration, frames);
  if (rows.y.size() < kEnoughRows) {
    return std::nullopt;
  }
  const auto solution = detail::solve(rows);
  return solution ? std::optional(TimeOffset{.seconds = solution->x(5), .sigma = solution->sigma_of_last})
                  : std::nullopt;
}

/// Where the pieces differ by more than their own sigmas say, theirs is what they differ by.
std::optional<TimeOffset> weighted_mean(const std::vector<TimeOffset>& pieces) {
  double weights = 0.0, sum = 0.0, squares = 0.0;
  for (const TimeOffset& piece : pieces) {
    const double weight = 1.0 / (piece.sigma * piece.sigma);
    weights += weight;
    sum += weight * piece.seconds;
  }
  if (!(weights > 0.0) || !std::isfinite(weights)) {
    return std::nullopt;
  }
  const double mean = sum / weights;
  for (const TimeOffset& piece : pieces) {
    squares += std::pow((piece.seconds - mean) / piece.sigma, 2);
  }
  const double spread = squares / std::max(1.0, static_cast<double>(pieces.size()) - 1.0);
  return TimeOffset{.seconds = mean, .sigma = std::sqrt(std::max(1.0, spread) / weights)};
}

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

std::optional<TimeOffset> cam1_time_offset(const StereoCalibration& calibration,
                                           std::span<const StereoFrame> frames) {
  std::vector<TimeOffset> pieces;
  while (!frames.empty()) {
    const auto beyond = std::find_if(frames.begin(), frames.end(), [&](const StereoFrame& frame) {
      return seconds_between(frames.front().t_ns, frame.t_ns) > kPiece;
    });
    const auto size = static_cast<std::size_t>(beyond - frames.begin());
    if (const auto piece = offset_of_piece(calibration, frames.first(size))) {
      pieces.push_back(*piece);
    }
    frames = frames.subspan(size);
  }
  return weighted_mean(pieces);
}

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
