// SPDX-License-Identifier: MIT
#include "limber/diagnose/cameras_beside_imu.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>
#include <vector>

#include "diagnose/compared_turns.hpp"
#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"
#include "diagnose/surest_part.hpp"
#include "limber/core/median.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

using detail::BiasSteps, detail::Compared, detail::rows_of;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kEnoughPairs = 20;
constexpr int kShifts = 8;
constexpr std::size_t kEnoughClusters = 4;
constexpr double kLargestOffset = 1.0;  // [s]
constexpr double kLeastTurning = 0.03;  // beside which the noise of a gyro is small [rad/s]

std::optional<MountTurn> mount_turn(const std::vector<Compared>& compared, const BiasSteps& steps) {
  const auto by_axes = detail::solve(rows_of(compared, steps, skew));
  if (!by_axes) {
    return std::nullopt;
  }
  const Vector3d direction =
      detail::surest_part(by_axes->x.tail<3>(), by_axes->covariance.bottomRightCorner<3, 3>())
          .value.normalized();
  const Matrix3d last_along_it = rotation_between(Vector3d::UnitZ(), direction);
  const auto along_it = detail::solve(
      rows_of(compared, steps, [&](const Vector3d& gyro) { return Matrix3Xd(skew(gyro) * last_along_it); }));
  if (!along_it || !direction.allFinite()) {
    return std::nullopt;
  }
  return MountTurn{along_it->last() * direction, along_it->sigma_of_last(), along_it->dof_of_last()};
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
std::vector<TurnScale> turn_scales(const std::vector<Compared>& compared, const BiasSteps& steps,
                                   const Matrix3d& R_body_cam0) {
  std::vector<TurnScale> out;
  for (const TurnFactor factor : {TurnFactor::kFocalLength, TurnFactor::kGyro, TurnFactor::kGyroX,
                                  TurnFactor::kGyroY, TurnFactor::kGyroZ}) {
    const Matrix3d part = share_of(factor, R_body_cam0);
    if (turning(compared, part) < kLeastTurning) {
      continue;
    }
    const auto solution = detail::solve(rows_of(compared, steps, [&](const Vector3d& gyro) {
      Matrix3Xd columns(3, 4);
      columns << skew(gyro), part * gyro;
      return columns;
    }));
    if (solution) {
      out.push_back({factor, solution->last(), solution->sigma_of_last(), solution->dof_of_last()});
    }
  }
  return out;
}

/// The turns at the clock's offset, which is found from where it stands on.
/// @return nothing where too few of them tell, or the offset goes away
std::optional<std::vector<Compared>> settle_clock(const std::vector<detail::Turn>& turns,
                                                  const detail::GyroAttitude& gyro, const BiasSteps& steps,
                                                  TimeOffset& clock) {
  std::vector<Compared> compared;
  for (int i = 0; i < kShifts; ++i) {
    compared = detail::compare(turns, gyro, clock.seconds);
    std::set<std::int64_t> clusters;
    for (const Compared& turn : compared) {
      clusters.insert(detail::cluster_of(turn));
    }
    if (compared.size() < kEnoughPairs || clusters.size() < kEnoughClusters) {
      return std::nullopt;
    }
    const auto solution =
        detail::solve(rows_of(compared, steps, [](const Vector3d&) { return Matrix3Xd(3, 0); }));
    if (!solution) {
      return std::nullopt;
    }
    clock.seconds += solution->last();
    clock.sigma = solution->sigma_of_last();
    clock.dof = solution->dof_of_last();
    if (std::abs(clock.seconds) > kLargestOffset) {
      return std::nullopt;
    }
  }
  return compared;
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
  BiasSteps steps;
  auto compared = settle_clock(turns, gyro, steps, out.clock);
  if (compared) {
    steps = detail::bias_steps(*compared);
    compared = steps.empty() ? std::move(compared) : settle_clock(turns, gyro, steps, out.clock);
  }
  if (!compared) {
    return std::nullopt;
  }
  out.mount = mount_turn(*compared, steps);
  out.scales = turn_scales(*compared, steps, calibration.T_body_cam0.R);
  out.confusion = usual_confusion(turns);
  return out;
}

}  // namespace limber
