// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/frontend/grey_image.hpp"
#include "limber/sensors/calibration.hpp"

/// Rendered images whose geometry is known exactly: the inside of a box with painted walls. A box is convex,
/// so that nothing hides anything.
namespace limber::testing {

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;

  [[nodiscard]] GreyImage view() const { return {width, height, width, pixels.data()}; }
};

inline Image plain_image(int width, int height, std::uint8_t grey) {
  return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), grey)};
}

/// How a camera turns light into grey levels.
struct Exposure {
  double gain = 1.0, offset = 0.0;
  double sigma = 1.0;      ///< of the noise [grey levels]
  std::uint64_t seed = 1;  ///< of the noise
};

/// Smooth noise in [-1, 1] with a lattice of spacing 1; each wall has its own.
double lattice_noise(std::uint32_t wall, double x, double y);

/// The point of the room that the pixel uv sees.
Eigen::Vector3d point_seen(const Camera& camera, const Pose& T_world_cam, const Eigen::Vector2d& uv);

/// What the camera sees from a place in the room. Pixels outside the camera model are black.
Image photograph(const Camera& camera, const Pose& T_world_cam, const Exposure& exposure);

/// A small rig with lens distortion, and different lenses left and right.
StereoCalibration small_rig();

/// Where the left camera is in frame k: it flies forward, sideways and turns.
Pose flight(int k);

}  // namespace limber::testing
