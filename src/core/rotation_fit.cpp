// SPDX-License-Identifier: MIT
#include "limber/core/rotation_fit.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace limber {

RotationFit fit_rotation(const Eigen::Matrix3d& correlation) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d d = svd.singularValues();
  Eigen::Vector3d s = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) {
    s.z() = -1.0;
  }
  return {svd.matrixU() * s.asDiagonal() * svd.matrixV().transpose(), d, d.dot(s)};
}

}  // namespace limber
