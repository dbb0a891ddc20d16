// SPDX-License-Identifier: MIT
#include "pose_manifold.hpp"

#include "blocks.hpp"
#include "limber/core/so3.hpp"

namespace limber::detail {

int PoseManifold::AmbientSize() const { return kPoseBlock; }
int PoseManifold::TangentSize() const { return kPoseTangent; }

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Pose pose = pose_of(x);
  using Map = Eigen::Map<const Eigen::Vector3d>;
  write_pose({pose.R * so3_exp(Map(delta + 3)), pose.p + Map(delta)}, x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kPoseBlock, kPoseTangent, Eigen::RowMajor>> J(jacobian);
  J.setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Pose a = pose_of(x), b = pose_of(y);
  Eigen::Map<Eigen::Vector3d>{y_minus_x} = b.p - a.p;
  Eigen::Map<Eigen::Vector3d>{y_minus_x + 3} = so3_log(a.R.transpose() * b.R);
  return true;
}

bool PoseManifold::MinusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, kPoseTangent, kPoseBlock, Eigen::RowMajor>> J(jacobian);
  J.setIdentity();
  return true;
}

}  // namespace limber::detail
