// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

#include "limber/core/pose.hpp"
#include "limber/evaluate/association.hpp"

namespace limber {

/// What is taken out of an estimate before it is compared with the truth.
enum class AlignmentKind {
  kNone,       ///< nothing
  kFirstPose,  ///< position and yaw (about the world's z) of the first pose: four d.o.f., gravity stays
  kSe3,        ///< the rigid transform that fits all positions best
  kSim3        ///< the same with a scale
};

/// Unless it is kAligned, the transform is the identity and must not be used.
enum class AlignmentStatus {
  kAligned,
  kTooFewPoses,  ///< kFirstPose needs one pose, kSe3 and kSim3 need three
  kNoMotion,     ///< all positions of the estimate or of the truth coincide
  kStraightLine  ///< a rotation about the line of the positions is not determined
};

/// p_world_true = scale * R * p_world_est + p; attitudes are turned by R. The scale multiplies the estimate.
struct Alignment {
  /// unless kAligned the others mean nothing
  AlignmentStatus status = AlignmentStatus::kAligned;
  Pose T_true_est;  ///< between the worlds of truth and estimate
  /// multiplies the estimate [-]
  double scale = 1.0;

  /// A pose of the estimate in the world of the truth; its attitude is turned, its position scaled as well.
  [[nodiscard]] Pose operator*(const Pose& T_world_body) const {
    return {T_true_est.R * T_world_body.R, scale * (T_true_est.R * T_world_body.p) + T_true_est.p};
  }
};

/// Least squares over all positions for kSe3 and kSim3. [Umeyama1991], Eqs. (34)-(43).
[[nodiscard]] Alignment align(std::span<const MatchedPose> poses, AlignmentKind kind);

/// The status in plain words, e.g. "all positions lie on a straight line".
[[nodiscard]] std::string_view describe(AlignmentStatus status);

}  // namespace limber
