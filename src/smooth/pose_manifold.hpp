// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/manifold.h>

namespace limber::detail {

/// A pose block with the error of StateLayout: position additive, attitude R Exp(dtheta). Cost functions give
/// derivatives with respect to this error in the first six columns of the block and zero in the last.
class PoseManifold : public ceres::Manifold {
 public:
  [[nodiscard]] int AmbientSize() const override;
  [[nodiscard]] int TangentSize() const override;
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

}  // namespace limber::detail
