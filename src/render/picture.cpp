// SPDX-License-Identifier: MIT
#include "limber/render/picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "limber/core/random.hpp"

namespace limber {
namespace {

constexpr float kSky = 200.0f;  ///< grey level

/// A wall as a camera at one place sees it: linear forms of the bearing.
struct SeenWall {
  Eigen::Vector3f normal, u, v;  ///< in the camera frame
  float distance, u0, v0, width, height;
};

SeenWall seen_from(const Wall& wall, const Pose& T_world_cam) {
  const Eigen::Matrix3d to_cam = T_world_cam.R.transpose();
  const Eigen::Vector3d normal = wall.u.cross(wall.v), from_corner = T_world_cam.p - wall.corner;
  return {(to_cam * normal).cast<float>(),
          (to_cam * wall.u).cast<float>(),
          (to_cam * wall.v).cast<float>(),
          static_cast<float>(-normal.dot(from_corner)),
          static_cast<float>(wall.u.dot(from_corner)),
          static_cast<float>(wall.v.dot(from_corner)),
          static_cast<float>(wall.width),
          static_cast<float>(wall.height)};
}

}  // namespace

PictureCamera::PictureCamera(const Camera& camera) : camera_(camera) {
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  for (std::vector<float>* axis : {&x_, &y_, &z_}) axis->resize(pixels);
  for (std::size_t k = 0; k < pixels; ++k) {
    const auto u = static_cast<double>(k % static_cast<std::size_t>(camera.width));
    const auto v = static_cast<double>(k / static_cast<std::size_t>(camera.width));
    const Eigen::Vector3d bearing = unproject(camera, {u, v}).value_or(Eigen::Vector3d::Zero());
    x_[k] = static_cast<float>(bearing.x());
    y_[k] = static_cast<float>(bearing.y());
    z_[k] = static_cast<float>(bearing.z());
  }
}

std::vector<float> PictureCamera::light(const Scene& scene, const Pose& T_world_cam) const {
  const auto width = static_cast<std::size_t>(camera_.width);
  std::vector<float> grey(x_.size()), nearest(width);
  std::vector<int> which(width);
  std::vector<SeenWall> walls;
  for (const Wall& wall : scene.walls()) walls.push_back(seen_from(wall, T_world_cam));
  const auto texels = static_cast<float>(1.0 / scene.texel());
  const auto pixel = static_cast<float>(2.0 / (camera_.fu + camera_.fv));  // [rad]
  for (std::size_t row = 0; row < grey.size(); row += width) {
    const float *x = &x_[row], *y = &y_[row], *z = &z_[row];
    std::fill(nearest.begin(), nearest.end(), std::numeric_limits<float>::max());
    std::fill(which.begin(), which.end(), -1);
    for (std::size_t w = 0; w < walls.size(); ++w) {
      const SeenWall wall = walls[w];
      if (wall.distance >= 0.0f) continue;  // from behind
      float* near = nearest.data();
      int* index = which.data();
      for (std::size_t k = 0; k < width; ++k) {  // becomes vector instructions
        const float towards = wall.normal[0] * x[k] + wall.normal[1] * y[k] + wall.normal[2] * z[k];
        const float t = wall.distance / towards;
        const float a = wall.u0 + t * (wall.u[0] * x[k] + wall.u[1] * y[k] + wall.u[2] * z[k]);
        const float b = wall.v0 + t * (wall.v[0] * x[k] + wall.v[1] * y[k] + wall.v[2] * z[k]);
        const bool hit = (towards < 0.0f) & (t < near[k]) & (a >= 0.0f) & (b >= 0.0f) & (a <= wall.width) &
                         (b <= wall.height);
        near[k] = hit ? t : near[k];
        index[k] = hit ? static_cast<int>(w) : index[k];
      }
    }
    for (std::size_t k = 0; k < width; ++k) {
      if (which[k] < 0) {
        grey[row + k] = x[k] == 0.0f && z[k] == 0.0f && y[k] == 0.0f ? 0.0f : kSky;
        continue;
      }
      const auto w = static_cast<std::size_t>(which[k]);
      const SeenWall& seen = walls[w];
      const Wall& wall = scene.walls()[w];
      const Eigen::Vector3f bearing(x[k], y[k], z[k]);
      const float a = seen.u0 + nearest[k] * seen.u.dot(bearing),
                  b = seen.v0 + nearest[k] * seen.v.dot(bearing);
      const float slant = std::max(0.05f, -seen.normal.dot(bearing));
      const float footprint = nearest[k] * pixel * texels / std::sqrt(slant);
      grey[row + k] = scene.textures()[wall.texture].at(a * texels + static_cast<float>(wall.offset.x()),
                                                        b * texels + static_cast<float>(wall.offset.y()),
                                                        footprint > 1.0f ? std::log2(footprint) : 0.0f);
    }
  }
  return grey;
}

std::vector<std::uint8_t> develop(const std::vector<float>& light, const Camera& camera,
                                  const SensorEffects& effects, std::uint64_t stream) {
  static const std::vector<float> kNormal = [] {  // drawn once: a picture needs half a million
    std::vector<float> values;
    const RandomStream draws(1, 0, "sensor noise");
    for (std::uint64_t i = 0; i < 1 << 15; ++i) {
      const Eigen::Vector2d pair = draws.normal2(i);
      values.insert(values.end(), {static_cast<float>(pair.x()), static_cast<float>(pair.y())});
    }
    return values;
  }();
  std::mt19937 generator(static_cast<std::uint32_t>(stream * 0x9E3779B97F4A7C15ull >> 32));
  const double corner2 = 0.25 * (camera.width * camera.width + camera.height * camera.height);
  std::vector<std::uint8_t> pixels(light.size());
  for (std::size_t k = 0; k < light.size(); ++k) {
    const double du = static_cast<double>(k % static_cast<std::size_t>(camera.width)) - 0.5 * camera.width;
    const double dv = static_cast<double>(k / static_cast<std::size_t>(camera.width)) - 0.5 * camera.height;
    const auto bright =
        static_cast<float>(effects.gain * (1.0 - effects.vignetting * (du * du + dv * dv) / corner2));
    float value = bright * light[k];
    if (effects.noise > 0.0) value += static_cast<float>(effects.noise) * kNormal[generator() & 0xFFFFu];
    pixels[k] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0l, 255l));
  }
  return pixels;
}

}  // namespace limber
