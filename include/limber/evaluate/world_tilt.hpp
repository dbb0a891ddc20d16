// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "limber/evaluate/alignment.hpp"
#include "limber/evaluate/association.hpp"
#include "limber/evaluate/consistency.hpp"

/// @file
/// Do the worlds of estimate and truth agree upon what is down? The truth of a recording may stand in the
/// frame of a marker or of a first camera, whose z axis is not up. How it is decided:
/// docs/truth-not-level.md.
namespace limber {

/// How the estimate's vertical (its z axis) lies in the world of the truth, over a whole run.
struct WorldTilt {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< it, mean over the poses, unit length
  double angle = 0.0;                             ///< between `up` and the truth's z [rad], 0 to pi
  double spread = 0.0;                            ///< RMS angle of the single poses from `up` [rad]
  std::optional<double> sigma;                    ///< what the filter claims of its tilt, RMS [rad]

  /// The truth's world stands askew: the same tilt throughout, by more than the estimate's errors explain.
  /// Else what differs is an error of the estimate.
  [[nodiscard]] bool is_askew() const;
};

/// Less is counted as an error of the estimate [rad]: an accelerometer's bias of 0.5 m/s² tilts by as much.
inline constexpr double kLeastWorldTilt = 0.0524;  // 3 deg
/// So many times its spread, and the claimed standard deviation, the tilt of a world has to be.
inline constexpr double kWorldTiltRatio = 5.0;

/// @param[in] covariances of the estimate, one per estimated pose: MatchedPose::index counts in this list;
/// may be empty, then sigma is not known
/// @return nothing if there are no poses, or the verticals have no mean
/// @throws std::invalid_argument if there are covariances, but an index has none
[[nodiscard]] std::optional<WorldTilt> world_tilt(std::span<const MatchedPose> poses,
                                                  std::span<const PoseCovariance> covariances = {});

/// @brief The truth's world set upright by its mean tilt, then AlignmentKind::kFirstPose: two d.o.f. are
/// fitted to all attitudes, four to the first pose. @param poses  not empty
[[nodiscard]] Alignment align_upright(std::span<const MatchedPose> poses, const WorldTilt& tilt);

}  // namespace limber
