// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

/// Rotations. `R_a_b` maps b-coordinates to a. The local (right) perturbation is used throughout:
/// `R_true = R_est * Exp(dtheta)`, dtheta [rad] in the frame b. [Sola2018], Eqs. (69)-(146).
namespace limber {

/// [v]_x, so that skew(v) * w = v x w.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// Rotation matrix of the rotation vector phi [rad]. Exact to rounding near zero.
[[nodiscard]] Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi);

/// Rotation vector [rad] of R, norm in [0, pi].
[[nodiscard]] Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);

/// Jr(phi): Exp(phi + d) = Exp(phi) Exp(Jr(phi) d) to first order.
[[nodiscard]] Eigen::Matrix3d so3_right_jacobian(const Eigen::Vector3d& phi);

/// Inverse of Jr(phi), for |phi| < 2 pi.
[[nodiscard]] Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& phi);

/// Whether R is a rotation matrix, up to the few digits of numbers written by hand.
[[nodiscard]] bool is_rotation(const Eigen::Matrix3d& R);
/// @throws std::invalid_argument, which calls R by its name, if it is none
void require_rotation(const Eigen::Matrix3d& R, const std::string& name);

/// The nearest rotation matrix, for a matrix that is one up to rounding.
[[nodiscard]] Eigen::Matrix3d so3_normalized(const Eigen::Matrix3d& R);

/// R = Rz(a.z) Ry(a.y) Rx(a.x), angles a [rad]. Paper, Eq. (22).
[[nodiscard]] Eigen::Matrix3d rotation_from_euler_zyx(const Eigen::Vector3d& angles);

/// Angles [rad] with R = Rz(z) Ry(y) Rx(x); y in [-pi/2, pi/2].
[[nodiscard]] Eigen::Vector3d euler_zyx_from_rotation(const Eigen::Matrix3d& R);

/// Columns w_k with dR/da_k = skew(w_k) R for R = Rz(a.z) Ry(a.y) Rx(a.x).
[[nodiscard]] Eigen::Matrix3d euler_zyx_axes(const Eigen::Vector3d& angles);

/// Shortest rotation that takes the unit vector `from` to the unit vector `to`.
[[nodiscard]] Eigen::Matrix3d rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace limber
