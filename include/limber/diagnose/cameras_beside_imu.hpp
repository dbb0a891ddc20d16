// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "limber/diagnose/time_offset.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// @file
/// Where and when the cameras are beside the IMU, by how both turned: a wrong clock looks like a rig that
/// bends while it moves, a mount that is turned tilts the world. Least squares with Huber weights over a
/// whole recording, apart from any filter.
namespace limber {

/// How cam0 is turned on the body, beside what the calibration says (true minus assumed: R_true = exp(turn)
/// R_assumed).
struct MountTurn {
  Eigen::Vector3d turn =
      Eigen::Vector3d::Zero();  ///< in body axes [rad]; without what the motion hardly tells
  double sigma = 0.0;           ///< of its length [rad]
  double dof = 0.0;             ///< of sigma, as in TimeOffset
};

/// Whose error it may be that the cameras turn by more, or less, than the gyro says.
enum class TurnFactor {
  kFocalLength,  ///< of cam0: all turns but those about its axis
  kGyro,         ///< its scale, of all axes
  kGyroX,        ///< of one axis alone
  kGyroY,        ///< ...
  kGyroZ         ///< ...
};

/// By how much, if it is that factor alone.
struct TurnScale {
  TurnFactor of = TurnFactor::kFocalLength;  ///< the factor
  double excess = 0.0;                       ///< of the camera's turns over the gyro's, as a share of them
  double sigma = 0.0;                        ///< of excess
  double dof = 0.0;                          ///< of sigma, as in TimeOffset
};

/// What the turns of a recording say of the cameras and the IMU.
struct CamerasBesideImu {
  TimeOffset clock;                ///< how much later than stamped the cameras see, by the clock of the IMU
  std::optional<MountTurn> mount;  ///< nothing where the motion tells none of it
  std::vector<TurnScale> scales;   ///< of the factors whose turns the motion holds, each beside the mount
  /// How many times as far an error of the pixels reaches into a turn, because it looks like a shift, too: of
  /// the usual turn.
  double confusion = 1.0;
};

/// @brief How the left camera alone turned in a fifth of a second (two views, depths eliminated: errors of
/// depth would look like turns), against the gyro over the same time, moved by tau; with a gyro
/// bias that is constant but for the few steps that the turns show for sure. The gyro's slope before and
/// behind is the instrument of its slope between. The mount's turn phi is found beside both, at that tau: a
/// camera that is taken for turned by phi less sees omega + omega x phi. Of the one, two or three directions
/// that the motion tells best those are taken whose turn is surest. Sigmas are the jackknife's over seconds
/// of the recording, with one d.o.f. less than there are seconds that tell. They do not hold what a lens
/// model leaves, which lasts: see mount_mistake.
/// @return nothing unless the body is the IMU and 20 pairs of frames in four seconds tell
[[nodiscard]] std::optional<CamerasBesideImu> cameras_beside_imu(const StereoCalibration& calibration,
                                                                 std::span<const StereoFrame> frames,
                                                                 std::span<const ImuSample> imu);

}  // namespace limber
