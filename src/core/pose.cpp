// SPDX-License-Identifier: MIT
#include "limber/core/pose.hpp"

namespace limber {

using Eigen::Vector3d;

Pose Pose::inverse() const { return {R.transpose(), -(R.transpose() * p)}; }

Vector3d Pose::operator*(const Vector3d& point) const { return R * point + p; }

Pose Pose::operator*(const Pose& other) const { return {R * other.R, R * other.p + p}; }

Pose interpolate(const Pose& a, const Pose& b, double s) {
  return {a.R * so3_exp(s * so3_log(a.R.transpose() * b.R)), (1.0 - s) * a.p + s * b.p};
}

}  // namespace limber
