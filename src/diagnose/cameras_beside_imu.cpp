// SPDX-License-Identifier: MIT
#include "limber/diagnose/cameras_beside_imu.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "diagnose/clustered_regression.hpp"
#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"
#include "limber/core/median.hpp"
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
constexpr double kLeastTurning = 0.03;  // beside which the noise of a gyro is small [rad/s]

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

/// What unknowns of one's own add to the camera's rate, by the gyro's.
using Columns = std::function<Matrix3Xd(const Vector3d& gyro)>;

/// Rows for (bias, a change of tau, unknowns of one's own). The instrument of the gyro's slope is its slope
/// over a while before and behind: noise of the samples between is in both sides, and alone looks like
/// milliseconds.
ClusteredRows rows_of(const std::vector<Compared>& compared, const Columns& more) {
  ClusteredRows rows;
  for (const Compared& turn : compared) {
    const Matrix3Xd columns = more(turn.gyro);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      VectorXd row = VectorXd::Zero(4 + columns.cols());
      row(axis) = 1.0;
      row.tail(columns.cols()) = columns.row(axis);
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
  const auto by_axes = detail::solve(rows_of(compared, skew));
  if (!by_axes) {
    return std::nullopt;
  }
  const Vector3d direction =
      surest_part(by_axes->x.tail<3>(), by_axes->covariance.bottomRightCorner<3, 3>()).normalized();
  const Matrix3d last_along_it = Quaterniond::FromTwoVectors(Vector3d::UnitZ(), direction).toRotationMatrix();
  const auto along_it = detail::solve(
      rows_of(compared, [&](const Vector3d& gyro) { return Matrix3Xd(skew(gyro) * last_along_it); }));
  if (!along_it || !direction.allFinite()) {
    return std::nullopt;
  }
  return MountTurn{along_it->x(6) * direction, along_it->sigma_of_last(), along_it->dof_of_last()};
}

/// The part of a body's rate that grows with a factor.
Matrix3d share_of(TurnFactor factor, const Matrix3d& R_body_cam0) {
  switch (factor) {
    case TurnFactor::kFocalLength:
      return R_body_cam0 * Vector3d(1.0, 1.0, 0.0).asDiagonal() * R_body_cam0.transpose();
    case TurnFactor::kGyro:
      return Matrix3d::Identity();
    case TurnFactor::kGyroX:
    case TurnFactor::kGyroY:
    case TurnFactor::kGyroZ:
      break;
  }
  return Vector3d::Unit(static_cast<int>(factor) - static_cast<int>(TurnFactor::kGyroX)).asDiagonal();
}

/// Root mean square of the gyro's rate in a part, less its mean [rad/s].
double turning(const std::vector<Compared>& compared, const Matrix3d& part) {
  Vector3d mean = Vector3d::Zero();
  double squares = 0.0;
  const double share = 1.0 / static_cast<double>(compared.size());
  for (const Compared& turn : compared) {
    mean += share * part * turn.gyro;
    squares += share * (part * turn.gyro).squaredNorm();
  }
  return std::sqrt(std::max(0.0, squares - mean.squaredNorm()));
}

/// Beside a mount that may be turned, as well.
std::vector<TurnScale> turn_scales(const std::vector<Compared>& compared, const Matrix3d& R_body_cam0) {
  std::vector<TurnScale> out;
  for (const TurnFactor factor : {TurnFactor::kFocalLength, TurnFactor::kGyro, TurnFactor::kGyroX,
                                  TurnFactor::kGyroY, TurnFactor::kGyroZ}) {
    const Matrix3d part = share_of(factor, R_body_cam0);
    if (turning(compared, part) < kLeastTurning) {
      continue;
    }
    const auto solution = detail::solve(rows_of(compared, [&](const Vector3d& gyro) {
      Matrix3Xd columns(3, 4);
      columns << skew(gyro), part * gyro;
      return columns;
    }));
    if (solution) {
      out.push_back({factor, solution->x(7), solution->sigma_of_last(), solution->dof_of_last()});
    }
  }
  return out;
}

double usual_confusion(const std::vector<detail::Turn>& turns) {
  std::vector<double> all;
  for (const detail::Turn& turn : turns) {
    all.push_back(turn.confusion);
  }
  return upper_median(std::move(all));
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
    const auto solution = detail::solve(rows_of(compared, [](const Vector3d&) { return Matrix3Xd(3, 0); }));
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
  out.scales = turn_scales(compared, calibration.T_body_cam0.R);
  out.confusion = usual_confusion(turns);
  return out;
}

}  // namespace limber
