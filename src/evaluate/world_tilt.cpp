// SPDX-License-Identifier: MIT
#include "limber/evaluate/world_tilt.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "limber/core/angle.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

constexpr double kNoMean = 1e-3;  // length of the mean of unit vectors that point everywhere

/// Variance of the two tilts about horizontal axes, summed [rad²]; the attitude's error is in the body frame.
double tilt_variance(const MatchedPose& pose, const PoseCovariance& P) {
  const Eigen::Matrix3d& R = pose.estimate.R;
  const Eigen::Matrix3d in_world = R * P.bottomRightCorner<3, 3>() * R.transpose();
  return in_world(0, 0) + in_world(1, 1);
}

std::optional<double> claimed_sigma(std::span<const MatchedPose> poses,
                                    std::span<const PoseCovariance> covariances) {
  if (covariances.empty()) {
    return std::nullopt;
  }
  double sum = 0.0;
  for (const MatchedPose& pose : poses) {
    if (pose.index >= covariances.size()) {
      throw std::invalid_argument("tilt of the worlds: pose " + std::to_string(pose.index) +
                                  " has no covariance");
    }
    sum += tilt_variance(pose, covariances[pose.index]);
  }
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

}  // namespace

bool WorldTilt::is_askew() const {
  return angle > std::max(kLeastWorldTilt, kWorldTiltRatio * std::max(spread, sigma.value_or(0.0)));
}

std::optional<WorldTilt> world_tilt(std::span<const MatchedPose> poses,
                                    std::span<const PoseCovariance> covariances) {
  if (poses.empty()) {
    return std::nullopt;
  }
  std::vector<Eigen::Vector3d> up;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const MatchedPose& pose : poses) {
    up.emplace_back(pose.truth.R * pose.estimate.R.transpose() * Eigen::Vector3d::UnitZ());
    sum += up.back();
  }
  const auto n = static_cast<double>(poses.size());
  if (!(sum.norm() > kNoMean * n)) {
    return std::nullopt;
  }
  WorldTilt out;
  out.up = sum.normalized();
  out.angle = angle_between(out.up, Eigen::Vector3d::UnitZ());
  double squares = 0.0;
  for (const Eigen::Vector3d& one : up) {
    squares += std::pow(angle_between(one, out.up), 2);
  }
  out.spread = std::sqrt(squares / n);
  out.sigma = claimed_sigma(poses, covariances);
  return out;
}

Alignment align_upright(std::span<const MatchedPose> poses, const WorldTilt& tilt) {
  const Pose T_upright_true{rotation_between(tilt.up, Eigen::Vector3d::UnitZ()), Eigen::Vector3d::Zero()};
  MatchedPose first = poses.front();
  first.truth = T_upright_true * first.truth;
  Alignment out = align(std::span(&first, 1), AlignmentKind::kFirstPose);
  out.T_true_est = T_upright_true.inverse() * out.T_true_est;
  return out;
}

}  // namespace limber
