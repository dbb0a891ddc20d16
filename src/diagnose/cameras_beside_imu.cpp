// SPDX-License-Identifier: MIT
#include "limber/diagnose/cameras_beside_imu.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <limits>
#include <set>
#include <vector>

#include "diagnose/clustered_regression.hpp"
#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

using detail::ClusteredRows;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Quaterniond;
using Eigen::SelfAdjointEigenSolver;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kEnoughPairs = 20;
constexpr int kShifts = 8;
constexpr double kAround = 0.15;  // length of what is before and behind a turn [s]
constexpr double kCluster = 1.0;  // [s]
constexpr std::size_t kEnoughClusters = 4;
constexpr double kLargestOffset = 1.0;  // [s]
constexpr double kSurest = 5.0;         // standard deviations

/// A turn by the camera, and by the gyro at the present tau.
struct Compared {
  Vector3d camera, gyro;   // mean rates [rad/s]
  Vector3d slope, around;  // of the gyro's rate over the turn; and over a while before and behind [rad/s^2]
  std::int64_t cluster;
};

/// Turns that overlap, and the tracks that they see, share a cluster.
std::vector<Compared> compare(const std::vector<detail::Turn>& turns, const detail::GyroAttitude& gyro,
                              double tau) {
  std::vector<Compared> out;
  const double sample = gyro.sample_time();
  for (const detail::Turn& turn : turns) {
    const double begin = turn.begin_s + tau, end = turn.end_s + tau;
    const auto mean = gyro.mean_rate(begin, end), first = gyro.rate(begin), last = gyro.rate(end);
    const auto before = gyro.mean_rate(begin - sample - kAround, begin - sample),
               behind = gyro.mean_rate(end + sample, end + sample + kAround);
    if (mean && first && last && before && behind) {
      out.push_back({turn.rate, *mean, (*last - *first) / (end - begin),
                     (*behind - *before) / (end - begin + 2.0 * sample + kAround),
                     static_cast<std::int64_t>(turn.begin_s / kCluster)});
    }
  }
  return out;
}

/// Rows for (bias, a change of tau, the mount's turn along the columns of `directions`, if there are any).
/// The instrument of the gyro's slope is its slope over a while before and behind: noise of the samples
/// between is in both sides, and alone looks like milliseconds.
ClusteredRows rows_of(const std::vector<Compared>& compared, const Matrix3Xd& directions) {
  ClusteredRows rows;
  for (const Compared& turn : compared) {
    const Matrix3Xd by_mount = skew(turn.gyro) * directions;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      VectorXd row = VectorXd::Zero(4 + directions.cols());
      row(axis) = 1.0;
      row.tail(directions.cols()) = by_mount.row(axis);
      row(3) = turn.slope(axis);
      rows.A.push_back(row);
      row(3) = turn.around(axis);
      rows.Z.push_back(row);
      rows.y.push_back(turn.camera(axis) - turn.gyro(axis));
      rows.cluster.push_back(turn.cluster);
    }
  }
  return rows;
}

/// Of a turn, the part within the one, two or three directions that are known best of which most is sure.
Vector3d surest_part(const Vector3d& turn, const Matrix3d& covariance) {
  const SelfAdjointEigenSolver<Matrix3d> axes(covariance);  // the best known first
  Vector3d part = Vector3d::Zero(), surest = part;
  double most = -std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vector3d axis = axes.eigenvectors().col(k);
    part += axis * axis.dot(turn);
    const Vector3d along = part.normalized();
    const double sure = part.norm() - kSurest * std::sqrt(along.dot(covariance * along));
    if (sure > most) {
      most = sure;
      surest = part;
    }
  }
  return surest;
}

std::optional<MountTurn> mount_turn(const std::vector<Compared>& compared) {
  const auto by_axes = detail::solve(rows_of(compared, Matrix3d::Identity()));
  if (!by_axes) {
    return std::nullopt;
  }
  const Vector3d direction =
      surest_part(by_axes->x.tail<3>(), by_axes->covariance.bottomRightCorner<3, 3>()).normalized();
  const Matrix3d last_along_it = Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction).toRotationMatrix();
  const auto along_it = detail::solve(rows_of(compared, last_along_it));
  if (!along_it || !direction.allFinite()) {
    return std::nullopt;
  }
  return MountTurn{along_it->x(6) * direction, along_it->sigma_of_last(), along_it->dof_of_last()};
}

}  // namespace

std::optional<CamerasBesideImu> cameras_beside_imu(const StereoCalibration& calibration,
                                                   std::span<const StereoFrame> frames,
                                                   std::span<const ImuSample> imu) {
  if (calibration.body != BodyFrame::kImu || imu.size() < 2 || frames.size() < kEnoughPairs) {
    return std::nullopt;
  }
  const detail::GyroAttitude gyro(imu);
  const std::vector<detail::Turn> turns = detail::left_turns(calibration, frames, imu.front().t_ns);
  CamerasBesideImu out;
  std::vector<Compared> compared;
  for (int i = 0; i < kShifts; ++i) {
    compared = compare(turns, gyro, out.clock.seconds);
    std::set<std::int64_t> clusters;
    for (const Compared& turn : compared) {
      clusters.insert(turn.cluster);
    }
    if (compared.size() < kEnoughPairs || clusters.size() < kEnoughClusters) {
      return std::nullopt;
    }
    const auto solution = detail::solve(rows_of(compared, Matrix3Xd(3, 0)));
    if (!solution) {
      return std::nullopt;
    }
    out.clock.seconds += solution->x(3);
    out.clock.sigma = solution->sigma_of_last();
    out.clock.dof = solution->dof_of_last();
    if (std::abs(out.clock.seconds) > kLargestOffset) {
      return std::nullopt;
    }
  }
  out.mount = mount_turn(compared);
  return out;
}

}  // namespace limber
