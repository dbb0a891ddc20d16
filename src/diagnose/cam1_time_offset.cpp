// SPDX-License-Identifier: MIT
// The clock of cam1 against that of cam0, by points that are off their epipolar lines while they move.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "diagnose/clustered_regression.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"
#include "limber/diagnose/time_offset.hpp"
#include "limber/measure/epipolar.hpp"

namespace limber {
namespace {

using detail::ClusteredRows;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLongestBetween = 0.3;  // [s] between frames that follow each other
constexpr std::size_t kEnoughRows = 200;
/// The rig may be another one in the next piece: one that jumps or drifts while it moves looks like an offset
/// [s].
constexpr double kPiece = 4.0;
constexpr int kRounds = 12;  // of Gauss-Newton
constexpr double kSettledTime =
    1.0;  // standard deviations: rows come and go with an offset, and step by half
constexpr double kSettledRig = 0.01;  // [rad, shares of the baseline]: second order is a hundredth of that
constexpr double kLargestCam1Offset = 0.5;  // [s]
constexpr double kLeastPieceDof = 1.0;
constexpr double kDoubt = 3.0;  // standard deviations
constexpr double kLate = 0.01;  // [s]

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

/// What both cameras see in a frame, and when.
struct Sight {
  double t_s = 0.0;  ///< since the first frame
  Followed points;
};

std::vector<Sight> sights_of(const StereoCalibration& calibration, std::span<const StereoFrame> frames) {
  std::vector<Sight> out;
  for (const StereoFrame& frame : frames) {
    Sight& sight = out.emplace_back(Sight{seconds_between(frames.front().t_ns, frame.t_ns), {}});
    for (const StereoObservation& o : frame.observations) {
      if (const auto pair = detail::bearings(calibration, o)) {
        sight.points[o.track_id] = *pair;
      }
    }
  }
  return out;
}

StereoBearings mix(const StereoBearings& a, const StereoBearings& b, double share_of_b) {
  return {(1.0 - share_of_b) * a.cam0 + share_of_b * b.cam0,
          (1.0 - share_of_b) * a.cam1 + share_of_b * b.cam1};
}

/// The same frames, with the right bearings of points as they were stamped `tau` before: where cam1 is that
/// late, they are those of the left camera's time. Between frames along a line.
std::vector<Sight> with_cam1_from(const std::vector<Sight>& sights, double tau) {
  std::vector<Sight> out;
  std::size_t behind = 1;  // the frame before `stamped` is behind - 1
  for (const Sight& sight : sights) {
    const double stamped = sight.t_s - tau;
    while (behind + 1 < sights.size() && sights[behind].t_s < stamped) {
      ++behind;
    }
    const Sight &a = sights[behind - 1], &b = sights[behind];
    Sight& shifted = out.emplace_back(Sight{sight.t_s, {}});
    if (stamped < a.t_s || stamped > b.t_s || b.t_s - a.t_s > kLongestBetween) {
      continue;
    }
    for (const auto& [id, pair] : sight.points) {
      const auto from = a.points.find(id), to = b.points.find(id);
      if (from != a.points.end() && to != b.points.end()) {
        const double share = (stamped - a.t_s) / (b.t_s - a.t_s);
        shifted.points[id] = {pair.cam0, mix(from->second, to->second, share).cam1};
      }
    }
  }
  return out;
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

/// Rows for what is assumed beyond the truth in the five directions, and for a change of the offset.
ClusteredRows epipolar_rows(const StereoCalibration& calibration, const std::vector<Sight>& sights) {
  const Pose T_cam1_cam0 = pose_from_rig(calibration.theta);
  const Eigen::Matrix<double, 6, 5> visible = visible_directions(calibration.theta);
  const auto slope_at = [&](const StereoBearings& pair) -> VectorXd {
    VectorXd row(6);
    row.head<5>() = (detail::epipolar_slope(pair, T_cam1_cam0) * visible).transpose();
    return row;
  };
  ClusteredRows rows;
  for (std::size_t n = 1; n + 1 < sights.size(); ++n) {
    const Followed &before = sights[n - 1].points, &after = sights[n + 1].points;
    const double dt = sights[n + 1].t_s - sights[n - 1].t_s;
    for (const auto& [id, pair] : sights[n].points) {
      const auto a = before.find(id), b = after.find(id);
      if (a == before.end() || b == after.end() || dt > 2.0 * kLongestBetween) {
        continue;
      }
      VectorXd row = slope_at(pair);
      row(5) = detail::epipolar_line(pair.cam0, T_cam1_cam0).dot(b->second.cam1 - a->second.cam1) / dt;
      // Without the noise of this frame, which is in the residual.
      const StereoBearings beside = mix(a->second, b->second, 0.5);
      const Vector3d line = detail::epipolar_line(beside.cam0, T_cam1_cam0);
      VectorXd instrument = slope_at(beside);
      instrument(5) = line.dot(T_cam1_cam0.R * (b->second.cam0 - a->second.cam0)) / dt;
      const double weight = 1.0 / std::sqrt(epipolar_variance(calibration, beside, line));
      rows.A.emplace_back(weight * row);
      rows.Z.emplace_back(weight * instrument);
      rows.y.push_back(weight * detail::epipolar_error(pair, T_cam1_cam0));
      rows.cluster.push_back(id);
    }
  }
  return rows;
}

/// With one rig for all of the frames, to first order about the one that is assumed; or, linear neither in
/// the rig nor where a picture is late, until that has settled.
std::optional<TimeOffset> offset_of_piece(StereoCalibration calibration, std::span<const StereoFrame> frames,
                                          bool first_order) {
  if (frames.size() < 3) {
    return std::nullopt;
  }
  const std::vector<Sight> stamped = sights_of(calibration, frames);
  double tau = 0.0;
  for (int round = 0; round < kRounds && std::abs(tau) < kLargestCam1Offset; ++round) {
    const ClusteredRows rows =
        epipolar_rows(calibration, tau == 0.0 ? stamped : with_cam1_from(stamped, tau));
    const auto solution = rows.y.size() < kEnoughRows ? std::nullopt : detail::solve(rows);
    if (!solution) {
      return std::nullopt;
    }
    const double step = solution->x(5);
    const VectorXd rig = solution->x.head<5>();
    if (first_order ||
        (std::abs(step) < kSettledTime * solution->sigma_of_last() && rig.norm() < kSettledRig)) {
      return TimeOffset{
          .seconds = tau + step, .sigma = solution->sigma_of_last(), .dof = solution->dof_of_last()};
    }
    tau += step;
    calibration.theta -=
        detail::pose_by_theta(calibration.theta).inverse() * (visible_directions(calibration.theta) * rig);
  }
  return std::nullopt;
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
  double one_by_dof = 0.0;  // as [Welch1947] adds variances that are estimated
  for (const TimeOffset& piece : pieces) {
    const double share = 1.0 / (piece.sigma * piece.sigma * weights);
    one_by_dof += share * share / std::max(piece.dof, kLeastPieceDof);
  }
  return TimeOffset{
      .seconds = mean, .sigma = std::sqrt(std::max(1.0, spread) / weights), .dof = 1.0 / one_by_dof};
}

std::optional<TimeOffset> mean_of_pieces(const StereoCalibration& calibration,
                                         std::span<const StereoFrame> frames, bool first_order) {
  std::vector<TimeOffset> pieces;
  while (!frames.empty()) {
    const auto beyond = std::find_if(frames.begin(), frames.end(), [&](const StereoFrame& frame) {
      return seconds_between(frames.front().t_ns, frame.t_ns) > kPiece;
    });
    const auto size = static_cast<std::size_t>(beyond - frames.begin());
    if (const auto piece = offset_of_piece(calibration, frames.first(size), first_order)) {
      pieces.push_back(*piece);
    }
    frames = frames.subspan(size);
  }
  return weighted_mean(pieces);
}

}  // namespace

/// To first order a rig that is as assumed tells its clock best: what is found of it has noise. Where that is
/// in doubt, the rig or the time may be so far off that there is more than first order.
std::optional<TimeOffset> cam1_time_offset(const StereoCalibration& calibration,
                                           std::span<const StereoFrame> frames) {
  const auto linear = mean_of_pieces(calibration, frames, true);
  const bool in_doubt =
      linear && (std::abs(linear->seconds) > kDoubt * linear->sigma || std::abs(linear->seconds) > kLate);
  return in_doubt ? mean_of_pieces(calibration, frames, false) : linear;
}

}  // namespace limber
