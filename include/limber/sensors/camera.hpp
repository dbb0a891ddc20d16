// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>

#include "limber/sensors/distortion.hpp"

/// Camera models. A point X is in the camera frame (x right, y down, z forward), any positive scale.
namespace limber {

/// Focal lengths, principal point and a lens model.
struct Camera {
  double fu = 1.0, fv = 1.0;  ///< focal lengths: pixels per radian on the axis [px]
  double cu = 0.0, cv = 0.0;  ///< principal point [px]
  int width = 0, height = 0;  ///< resolution [px]
  /// lens model
  Distortion distortion = NoDistortion{};

  /// member by member
  bool operator==(const Camera&) const = default;
};

/// Pixel of a point and its derivative.
struct Projection {
  Eigen::Vector2d uv;                  ///< [px], distorted
  Eigen::Matrix<double, 2, 3> J_uv_X;  ///< derivative with respect to X
};

/// @brief Projects X (3, camera frame, any positive scale) to raw pixels.
/// @return nothing where the model is not valid: z <= 0 (all but equidistant and omni), z <= -xi |X| or
/// |X| <= -xi z (omni), or where the distortion has folded back between the axis and X (of equidistant and
/// rational, looked at in 16 places).
[[nodiscard]] std::optional<Projection> project(const Camera& camera, const Eigen::Vector3d& X);

/// @brief Derivative of the pixel of X with respect to fu, fv, cu, cv and the first radial coefficient k1 (of
/// a camera without distortion: of a radial-tangential one whose coefficients are zero).
/// @param uv  the pixel of X, as project has it
[[nodiscard]] Eigen::Matrix<double, 2, 5> intrinsics_jacobian(const Camera& camera, const Eigen::Vector3d& X,
                                                              const Eigen::Vector2d& uv);

/// @brief Unit bearing (camera frame) of the raw pixel uv, the inverse of project, by Newton's method.
/// @return nothing where it does not converge: no ray has this pixel within the range that project states.
[[nodiscard]] std::optional<Eigen::Vector3d> unproject(const Camera& camera, const Eigen::Vector2d& uv);

/// Whether uv lies in the image, `border` [px] away from its edge.
[[nodiscard]] bool in_image(const Camera& camera, const Eigen::Vector2d& uv, double border = 0.0);

}  // namespace limber
