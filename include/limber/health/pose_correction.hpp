// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace limber {

/// How a frame corrected the predicted pose.
struct PoseCorrection {
  /// position [m], attitude [rad]
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  /// covariance of a Vector6
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// [ns], of the frame
  std::int64_t t_ns = 0;
  double dt = 0.0;     ///< since the frame before [s]
  Vector6 dx;          ///< position [m], attitude [rad]
  Matrix6 covariance;  ///< of dx, if the prediction was right: P before minus P after the update
  double nis = 0.0;    ///< of all rows [-]
  double dof = 0.0;    ///< of nis
};

/// The correction in units of its standard deviations, each near its own axis; directions that the frame did
/// not see are zero.
[[nodiscard]] PoseCorrection::Vector6 whitened(const PoseCorrection& correction);

/// NIS per degree of freedom of what the pose does not explain: it tells the noise.
/// @param z  the correction, whitened
[[nodiscard]] double scatter_beside(const PoseCorrection& correction, const PoseCorrection::Vector6& z);
/// The same.
[[nodiscard]] double scatter_beside(const PoseCorrection& correction);

}  // namespace limber
