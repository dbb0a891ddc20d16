// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>

/// Camera models that others have and limber has not. Projections of a point in front of the camera; nothing
/// where the model does not reach.
namespace limber::detail {

using ForeignProjection = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector3d&)>;

struct Pinhole {
  double fu = 1.0, fv = 1.0, cu = 0.0, cv = 0.0;
};

/// [Usenko2018] Double sphere.
[[nodiscard]] ForeignProjection double_sphere(const Pinhole& pinhole, double xi, double alpha);
/// [Usenko2018] Extended unified camera model.
[[nodiscard]] ForeignProjection extended_unified(const Pinhole& pinhole, double alpha, double beta);
/// OpenCV's k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4.
[[nodiscard]] ForeignProjection opencv_pinhole(const Pinhole& pinhole,
                                               const std::array<double, 12>& distortion);

}  // namespace limber::detail
