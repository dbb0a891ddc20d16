// SPDX-License-Identifier: MIT
#include "frontend/painted_room.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "limber/core/so3.hpp"

namespace limber::testing {

double lattice_noise(std::uint32_t wall, double x, double y) {
  const auto value = [wall](std::int64_t i, std::int64_t j) {
    std::uint64_t h = static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ull +
                      static_cast<std::uint64_t>(j) * 0xC2B2AE3D27D4EB4Full + wall * 0x165667B19E3779F9ull;
    h = (h ^ (h >> 31)) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 29)) * 0x94D049BB133111EBull;
    return static_cast<double>((h ^ (h >> 32)) & 0xFFFFFFull) / 0x7FFFFF - 1.0;
  };
  const double i = std::floor(x), j = std::floor(y);
  const auto smooth = [](double t) { return t * t * (3.0 - 2.0 * t); };
  const double fx = smooth(x - i), fy = smooth(y - j);
  const auto a = static_cast<std::int64_t>(i), b = static_cast<std::int64_t>(j);
  return (1 - fy) * ((1 - fx) * value(a, b) + fx * value(a + 1, b)) +
         fy * ((1 - fx) * value(a, b + 1) + fx * value(a + 1, b + 1));
}

namespace {

const Eigen::Vector3d kHalfSize(4.0, 2.5, 6.0);  ///< of the box [m]

/// Which wall (0 to 5) the ray hits, and where.
std::pair<std::uint32_t, Eigen::Vector3d> hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  std::uint32_t wall = 0;
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const double distance = (std::copysign(kHalfSize[axis], ray[axis]) - origin[axis]) / ray[axis];
    if (distance >= nearest) continue;
    nearest = distance;
    wall = 2 * axis + (ray[axis] > 0 ? 1 : 0);
  }
  return {wall, origin + nearest * ray};
}

double paint(std::uint32_t wall, const Eigen::Vector3d& at) {
  const std::uint32_t axis = wall / 2;
  const double x = at[(axis + 1) % 3], y = at[(axis + 2) % 3];
  return 128.0 + 60.0 * lattice_noise(wall, x / 0.5, y / 0.5) +
         50.0 * lattice_noise(wall + 8, x / 0.17, y / 0.17);
}

}  // namespace

Eigen::Vector3d point_seen(const Camera& camera, const Pose& T_world_cam, const Eigen::Vector2d& uv) {
  return hit(T_world_cam.p, T_world_cam.R * unproject(camera, uv).value()).second;
}

Image photograph(const Camera& camera, const Pose& T_world_cam, const Exposure& exposure) {
  Image image = plain_image(camera.width, camera.height, 0);
  std::mt19937_64 generator(exposure.seed);
  std::normal_distribution<double> noise(0.0, exposure.sigma);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto bearing = unproject(camera, Eigen::Vector2d(u, v));
      if (!bearing) continue;
      const auto [wall, at] = hit(T_world_cam.p, T_world_cam.R * *bearing);
      const double grey = exposure.gain * paint(wall, at) + exposure.offset + noise(generator);
      image.pixels[static_cast<std::size_t>(v * camera.width + u)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0l, 255l));
    }
  }
  return image;
}

StereoCalibration small_rig() {
  StereoCalibration rig;
  rig.cam0 = {230.0, 229.0, 186.0, 121.0, 376, 240, RadialTangential{-0.28, 0.07, 2e-4, 1e-4}};
  rig.cam1 = {228.0, 231.0, 190.0, 118.0, 376, 240, RadialTangential{-0.27, 0.06, -1e-4, 2e-4}};
  rig.theta << 0.0, 0.0, 0.0, -0.15, 0.0, 0.0;
  rig.body = BodyFrame::kCam0;
  return rig;
}

Pose flight(int k) {
  const double t = 0.05 * k;
  return {so3_exp(Eigen::Vector3d(0.05 * std::sin(3.0 * t), 0.12 * t, 0.10 * std::sin(2.0 * t))),
          Eigen::Vector3d(0.5 * t - 0.3, 0.1 * std::sin(4.0 * t), 0.7 * t - 2.0)};
}

}  // namespace limber::testing
