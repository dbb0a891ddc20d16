// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace limber {

/// The rotation that turns vectors x most nearly into their partners y.
struct RotationFit {
  /// y ~ R x
  Eigen::Matrix3d R;
  /// Singular values of the correlation, largest first: two of zero leave the rotation undetermined.
  Eigen::Vector3d singular_values;
  /// Trace of R^T correlation: over the sum of |x|^2 the scale in y ~ scale R x.
  double agreement = 0.0;
};

/// @param correlation  sum of y x^T, weighted or not
/// @note [Umeyama1991], Eqs. (39), (40), (43)
[[nodiscard]] RotationFit fit_rotation(const Eigen::Matrix3d& correlation);

}  // namespace limber
