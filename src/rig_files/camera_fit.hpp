// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "limber/sensors/camera.hpp"
#include "rig_files/foreign_cameras.hpp"

namespace limber::detail {

/// One of limber's cameras in place of a foreign one.
struct CameraFit {
  Camera camera;
  double worst_px = 0.0;  ///< largest distance between the two, anywhere in the image
};

/// Largest worst_px that is still taken for the same camera.
inline constexpr double kWorstFit_px = 0.1;

/// @brief The radial-tangential or equidistant camera that is closest over the whole image, by least squares
/// on the pixels of rays.
/// @param start  focal lengths (of rays near the axis), principal point, size: where the search begins
/// @return nothing if the image does not hold enough rays or nothing converges
[[nodiscard]] std::optional<CameraFit> fit_camera(const ForeignProjection& projection, const Camera& start);

}  // namespace limber::detail
