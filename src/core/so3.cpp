// SPDX-License-Identifier: MIT
#include "limber/core/so3.hpp"

#include <cmath>
#include <stdexcept>

namespace limber {
namespace {

// Below this angle [rad] the Taylor series of the coefficients is exact to double precision.
constexpr double kSmallAngle = 1e-4;
// Nearer to -1 than that, the cosine of two directions leaves no axis to turn about.
constexpr double kOpposite = 1e-12;
constexpr double kRotationTolerance = 1e-3;  // of an entry of R^T R - I

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double angle2 = angle * angle;
  const bool small = angle < kSmallAngle;
  const double a = small ? 1.0 - angle2 / 6.0 : std::sin(angle) / angle;
  const double b = small ? 0.5 - angle2 / 24.0 : (1.0 - std::cos(angle)) / angle2;
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() + a * K + b * K * K;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  // Through the quaternion: well conditioned at 0 and at pi.
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) {
    q.coeffs() = -q.coeffs();
  }
  const double sin_half = q.vec().norm();
  if (sin_half < 1e-12) {
    return 2.0 * q.vec();
  }
  return 2.0 * std::atan2(sin_half, q.w()) / sin_half * q.vec();
}

Eigen::Matrix3d so3_right_jacobian(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double angle2 = angle * angle;
  const bool small = angle < kSmallAngle;
  const double a = small ? 0.5 - angle2 / 24.0 : (1.0 - std::cos(angle)) / angle2;
  const double b = small ? 1.0 / 6.0 - angle2 / 120.0 : (angle - std::sin(angle)) / (angle2 * angle);
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() - a * K + b * K * K;
}

Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double angle2 = angle * angle;
  const double c = angle < kSmallAngle
                       ? 1.0 / 12.0 + angle2 / 720.0
                       : 1.0 / angle2 - std::cos(0.5 * angle) / (2.0 * angle * std::sin(0.5 * angle));
  const Eigen::Matrix3d K = skew(phi);
  return Eigen::Matrix3d::Identity() + 0.5 * K + c * K * K;
}

bool is_rotation(const Eigen::Matrix3d& R) {
  if (!R.allFinite()) {
    return false;
  }
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  return error < kRotationTolerance && R.determinant() > 0.0;
}

void require_rotation(const Eigen::Matrix3d& R, const std::string& name) {
  if (!is_rotation(R)) {
    throw std::invalid_argument(
        name + " is not orthonormal: expected R^T R = I and determinant 1, found |R^T R - I| = " +
        std::to_string((R.transpose() * R - Eigen::Matrix3d::Identity()).norm()) + ", determinant " +
        std::to_string(R.determinant()));
  }
}

Eigen::Matrix3d so3_normalized(const Eigen::Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

Eigen::Matrix3d rotation_from_euler_zyx(const Eigen::Vector3d& angles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
          AngleAxisd(angles.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Vector3d euler_zyx_from_rotation(const Eigen::Matrix3d& R) {
  // z is read off R Rx(x)^T = Rz Ry, so that the three angles rebuild R even where x and z are not unique.
  const double x = std::atan2(R(2, 1), R(2, 2));
  const double y = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const double sx = std::sin(x);
  const double cx = std::cos(x);
  return {x, y, std::atan2(sx * R(0, 2) - cx * R(0, 1), cx * R(1, 1) - sx * R(1, 2))};
}

Eigen::Matrix3d euler_zyx_axes(const Eigen::Vector3d& angles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  const Eigen::Matrix3d Rz = AngleAxisd(angles.z(), Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d Ry = AngleAxisd(angles.y(), Vector3d::UnitY()).toRotationMatrix();
  Eigen::Matrix3d axes;
  axes.col(0) = Rz * Ry.col(0);  // Rz Ry ex
  axes.col(1) = Rz.col(1);       // Rz ey
  axes.col(2) = Vector3d::UnitZ();
  return axes;
}

Eigen::Matrix3d rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  if (cosine < -1.0 + kOpposite) {  // half a turn about anything across, and the rest
    const Eigen::Vector3d axis = a.unitOrthogonal();
    return rotation_between(-a, b) * (2.0 * axis * axis.transpose() - Eigen::Matrix3d::Identity());
  }
  const double s = std::sqrt((1.0 + cosine) * 2.0);
  Eigen::Quaterniond q;
  q.vec() = a.cross(b) * (1.0 / s);
  q.w() = 0.5 * s;
  return q.toRotationMatrix();
}

}  // namespace limber
