// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>

/// Camera models. A point X is in the camera frame (x right, y down, z forward), any positive scale.
namespace limber {

/// Distortion of normalised coordinates: none.
struct NoDistortion {};

/// Radial-tangential ("plumb bob"): k1, k2, p1, p2 as in EuRoC and OpenCV.
struct RadialTangential {
  /// [-]
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;
};

/// Equidistant ("fisheye", Kannala-Brandt): theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8).
struct Equidistant {
  /// [-]
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, k4 = 0.0;
};

/// How a lens departs from a pinhole.
using Distortion = std::variant<NoDistortion, RadialTangential, Equidistant>;

/// Pinhole camera with distortion.
struct Camera {
  double fu = 1.0, fv = 1.0;  ///< focal lengths [px]
  double cu = 0.0, cv = 0.0;  ///< principal point [px]
  int width = 0, height = 0;  ///< resolution [px]
  /// of the normalised coordinates
  Distortion distortion = NoDistortion{};
};

/// Pixel of a point and its derivative.
struct Projection {
  Eigen::Vector2d uv;                  ///< [px], distorted
  Eigen::Matrix<double, 2, 3> J_uv_X;  ///< derivative with respect to X
};

/// @brief Projects X (3, camera frame, any positive scale) to raw pixels.
/// @return nothing where the model is not valid: z <= 0 (pinhole), or the distortion is not monotonic there.
[[nodiscard]] std::optional<Projection> project(const Camera& camera, const Eigen::Vector3d& X);

/// @brief Derivative of the pixel of X with respect to fu, fv, cu, cv and the first radial coefficient k1 (of
/// a camera without distortion: of a radial-tangential one whose coefficients are zero).
/// @param uv  the pixel of X, as project has it
[[nodiscard]] Eigen::Matrix<double, 2, 5> intrinsics_jacobian(const Camera& camera, const Eigen::Vector3d& X,
                                                              const Eigen::Vector2d& uv);

/// @brief Unit bearing (camera frame) of the raw pixel uv, the inverse of project.
/// @return nothing where the iteration does not converge (pixel outside the model's valid range).
[[nodiscard]] std::optional<Eigen::Vector3d> unproject(const Camera& camera, const Eigen::Vector2d& uv);

/// Whether uv lies in the image, `border` [px] away from its edge.
[[nodiscard]] bool in_image(const Camera& camera, const Eigen::Vector2d& uv, double border = 0.0);

}  // namespace limber
