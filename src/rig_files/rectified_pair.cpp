// SPDX-License-Identifier: MIT
#include "rig_files/rectified_pair.hpp"

#include <Eigen/Geometry>

#include "limber/core/pose.hpp"

namespace limber::detail {
namespace {

Eigen::Matrix<double, 3, 4> projection(const RectifiedPair& pair, double tx) {
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
  P(0, 0) = P(1, 1) = pair.f;
  P(0, 2) = pair.cu;
  P(1, 2) = pair.cv;
  P(2, 2) = 1.0;
  P(0, 3) = pair.f * tx;
  return P;
}

/// Principal point of the rectified image under which what was in the middle stays there.
Eigen::Vector2d centre(const Camera& camera, const Eigen::Matrix3d& R, double f) {
  const Eigen::Vector3d axis = R.col(2);
  return Eigen::Vector2d(camera.cu, camera.cv) - f * axis.head<2>() / axis.z();
}

}  // namespace

Eigen::Matrix<double, 3, 4> RectifiedPair::P0() const { return projection(*this, 0.0); }
Eigen::Matrix<double, 3, 4> RectifiedPair::P1() const { return projection(*this, -baseline); }

RectifiedPair rectify(const StereoCalibration& calibration) {
  const Pose T_cam0_cam1 = pose_from_rig(calibration.theta).inverse();
  const Eigen::Vector3d x = T_cam0_cam1.p.normalized();
  const Eigen::Vector3d ahead = (Eigen::Vector3d::UnitZ() + T_cam0_cam1.R.col(2)).normalized();
  const Eigen::Vector3d y = ahead.cross(x).normalized();
  RectifiedPair out;
  out.R0 << x.transpose(), y.transpose(), x.cross(y).transpose();
  out.R1 = out.R0 * T_cam0_cam1.R;
  const Camera &cam0 = calibration.cam0, &cam1 = calibration.cam1;
  out.f = 0.25 * (cam0.fu + cam0.fv + cam1.fu + cam1.fv);
  const Eigen::Vector2d c = 0.5 * (centre(cam0, out.R0, out.f) + centre(cam1, out.R1, out.f));
  out.cu = c.x();
  out.cv = c.y();
  out.baseline = calibration.baseline();
  return out;
}

}  // namespace limber::detail
