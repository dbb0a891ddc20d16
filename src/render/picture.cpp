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
  float offset_x, offset_y;  ///< of the texture [texels]
  const Texture* texture;
};

}  // namespace

/// The walls that a camera can see from one place.
class PictureCamera::SeenScene {
 public:
  explicit SeenScene(const Scene& scene) : scene_(scene) {}

  void look(const View& view) {
    walls_.clear();
    for (const Wall& wall : scene_.walls()) look_at(wall, view.T_world_cam);
    for (std::size_t k = 0; k < scene_.boxes().size(); ++k) {
      const Pose T_box_cam = scene_.boxes()[k].pose(view.t).inverse() * view.T_world_cam;
      for (const Wall& wall : scene_.walls_of_box(k)) look_at(wall, T_box_cam);
    }
  }

  /// Grey levels of row v of a camera.
  void expose(const PictureCamera& camera, std::size_t v, float* grey) {
    const auto first = static_cast<std::ptrdiff_t>(v * static_cast<std::size_t>(camera.camera_.width));
    find_nearest(camera, first);
    paint(camera, first, grey);
  }

 private:
  void look_at(const Wall& wall, const Pose& T_wall_cam) {
    const Eigen::Matrix3d to_cam = T_wall_cam.R.transpose();
    const Eigen::Vector3d normal = wall.u.cross(wall.v), from_corner = T_wall_cam.p - wall.corner;
    const auto distance = static_cast<float>(-normal.dot(from_corner));
    if (distance >= 0.0f) return;  // from behind
    walls_.push_back({(to_cam * normal).cast<float>(), (to_cam * wall.u).cast<float>(),
                      (to_cam * wall.v).cast<float>(), distance, static_cast<float>(wall.u.dot(from_corner)),
                      static_cast<float>(wall.v.dot(from_corner)), static_cast<float>(wall.width),
                      static_cast<float>(wall.height), static_cast<float>(wall.offset.x()),
                      static_cast<float>(wall.offset.y()), &scene_.textures()[wall.texture]});
  }

  void find_nearest(const PictureCamera& camera, std::ptrdiff_t first) {
    const auto width = static_cast<std::size_t>(camera.camera_.width);
    const float *x = &camera.x_[0] + first, *y = &camera.y_[0] + first, *z = &camera.z_[0] + first;
    nearest_.assign(width, std::numeric_limits<float>::max());
    which_.assign(width, -1);
    float* near = nearest_.data();
    int* index = which_.data();
    for (std::size_t w = 0; w < walls_.size(); ++w) {
      const SeenWall wall = walls_[w];
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
  }

  void paint(const PictureCamera& camera, std::ptrdiff_t first, float* grey) const {
    const float *x = &camera.x_[0] + first, *y = &camera.y_[0] + first, *z = &camera.z_[0] + first;
    const auto texels = static_cast<float>(1.0 / scene_.texel());
    const auto pixel = static_cast<float>(2.0 / (camera.camera_.fu + camera.camera_.fv));  // [rad]
    for (std::size_t k = 0; k < nearest_.size(); ++k) {
      if (which_[k] < 0) {
        grey[k] = x[k] == 0.0f && z[k] == 0.0f && y[k] == 0.0f ? 0.0f : kSky;
        continue;
      }
      const SeenWall& wall = walls_[static_cast<std::size_t>(which_[k])];
      const Eigen::Vector3f bearing(x[k], y[k], z[k]);
      const float a = wall.u0 + nearest_[k] * wall.u.dot(bearing),
                  b = wall.v0 + nearest_[k] * wall.v.dot(bearing);
      const float slant = std::max(0.05f, -wall.normal.dot(bearing));
      const float footprint = nearest_[k] * pixel * texels / std::sqrt(slant);
      grey[k] = wall.texture->at(a * texels + wall.offset_x, b * texels + wall.offset_y,
                                 footprint > 1.0f ? std::log2(footprint) : 0.0f);
    }
  }

  const Scene& scene_;
  std::vector<SeenWall> walls_;
  std::vector<float> nearest_;  ///< of the pixels of a row: lengths of the bearing
  std::vector<int> which_;      ///< of walls_; -1 for none
};

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

std::vector<float> PictureCamera::light(const Scene& scene, const View& view) const {
  const auto width = static_cast<std::size_t>(camera_.width);
  std::vector<float> grey(x_.size());
  SeenScene seen(scene);
  seen.look(view);
  for (std::size_t v = 0; v * width < grey.size(); ++v) seen.expose(*this, v, &grey[v * width]);
  return grey;
}

std::vector<float> PictureCamera::light(const Scene& scene,
                                        const std::function<View(std::size_t row)>& view_of) const {
  const auto width = static_cast<std::size_t>(camera_.width);
  std::vector<float> grey(x_.size());
  SeenScene seen(scene);
  for (std::size_t v = 0; v * width < grey.size(); ++v) {
    seen.look(view_of(v));
    seen.expose(*this, v, &grey[v * width]);
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
