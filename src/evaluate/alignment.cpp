// SPDX-License-Identifier: MIT
#include "limber/evaluate/alignment.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "limber/core/rotation_fit.hpp"

namespace limber {
namespace {

// Positions spread less than this share of their distance from the origin (or of a metre) do not move.
constexpr double kNoMotionShare = 1e-12;
// Second singular value of the correlation matrix below which positions are a line: they leave it by a
// millionth.
constexpr double kStraightLineShare = 1e-12;

Alignment undetermined(AlignmentStatus status) {
  Alignment alignment;
  alignment.status = status;
  return alignment;
}

struct Moments {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double variance = 0.0;

  [[nodiscard]] bool moves() const {
    return std::sqrt(variance) > kNoMotionShare * std::max(1.0, mean.lpNorm<Eigen::Infinity>());
  }
};

Moments moments(std::span<const MatchedPose> poses, Pose MatchedPose::*which) {
  Moments m;
  const auto n = static_cast<double>(poses.size());
  for (const MatchedPose& pose : poses) {
    m.mean += (pose.*which).p / n;
  }
  for (const MatchedPose& pose : poses) {
    m.variance += ((pose.*which).p - m.mean).squaredNorm() / n;
  }
  return m;
}

Alignment align_umeyama(std::span<const MatchedPose> poses, bool with_scale) {
  if (poses.size() < 3) {
    return undetermined(AlignmentStatus::kTooFewPoses);
  }
  const Moments x = moments(poses, &MatchedPose::estimate);  // Eqs. (34), (36)
  const Moments y = moments(poses, &MatchedPose::truth);     // Eqs. (35), (37)
  if (!x.moves() || !y.moves()) {
    return undetermined(AlignmentStatus::kNoMotion);
  }
  Eigen::Matrix3d Sigma_yx = Eigen::Matrix3d::Zero();  // Eq. (38)
  for (const MatchedPose& pose : poses) {
    Sigma_yx +=
        (pose.truth.p - y.mean) * (pose.estimate.p - x.mean).transpose() / static_cast<double>(poses.size());
  }
  const RotationFit fit = fit_rotation(Sigma_yx);
  if (fit.singular_values(1) <= kStraightLineShare * std::sqrt(x.variance * y.variance)) {
    return undetermined(AlignmentStatus::kStraightLine);
  }
  Alignment alignment;
  alignment.T_true_est.R = fit.R;                                                         // Eq. (40)
  alignment.scale = with_scale ? fit.agreement / x.variance : 1.0;                        // Eq. (42)
  alignment.T_true_est.p = y.mean - alignment.scale * (alignment.T_true_est.R * x.mean);  // Eq. (41)
  return alignment;
}

Alignment align_first_pose(std::span<const MatchedPose> poses) {
  if (poses.empty()) {
    return undetermined(AlignmentStatus::kTooFewPoses);
  }
  const Pose& estimate = poses.front().estimate;
  const Pose& truth = poses.front().truth;
  // Rz(yaw) nearest to R_true_est, whatever tilt error is left.
  const Eigen::Matrix3d R = truth.R * estimate.R.transpose();
  const double yaw = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
  Alignment alignment;
  alignment.T_true_est.R = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  alignment.T_true_est.p = truth.p - alignment.T_true_est.R * estimate.p;
  return alignment;
}

}  // namespace

Alignment align(std::span<const MatchedPose> poses, AlignmentKind kind) {
  switch (kind) {
    case AlignmentKind::kFirstPose:
      return align_first_pose(poses);
    case AlignmentKind::kSe3:
      return align_umeyama(poses, false);
    case AlignmentKind::kSim3:
      return align_umeyama(poses, true);
    case AlignmentKind::kNone:
      break;
  }
  return {};
}

std::string_view describe(AlignmentStatus status) {
  switch (status) {
    case AlignmentStatus::kTooFewPoses:
      return "too few poses";
    case AlignmentStatus::kNoMotion:
      return "all positions coincide";
    case AlignmentStatus::kStraightLine:
      return "all positions lie on a straight line";
    case AlignmentStatus::kAligned:
      break;
  }
  return "aligned";
}

}  // namespace limber
