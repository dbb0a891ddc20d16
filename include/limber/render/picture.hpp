// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/render/scene.hpp"
#include "limber/sensors/camera.hpp"

namespace limber {

/// From where, and when [s], light is taken in.
struct View {
  /// since the start of the recording [s]
  double t = 0.0;
  /// of the camera then
  Pose T_world_cam;
};

/// @brief Takes images of a scene: one ray through the centre of each pixel of any lens, exact to single
/// precision; the texture's pyramid keeps what is far from flickering.
class PictureCamera {
 public:
  /// @param camera  its lens and resolution
  explicit PictureCamera(const Camera& camera);

  /// Light at each pixel, row by row: grey levels, 0 where the lens shows nothing.
  [[nodiscard]] std::vector<float> light(const Scene& scene, const View& view) const;

  /// The same through a rolling shutter: every row has a view of its own.
  [[nodiscard]] std::vector<float> light(const Scene& scene,
                                         const std::function<View(std::size_t row)>& view_of) const;

 private:
  class SeenScene;

  Camera camera_;
  std::vector<float> x_, y_, z_;  ///< unit bearings of the pixels; zero where there is none
};

/// How light becomes grey values. Everything is off by default.
struct SensorEffects {
  double noise = 0.0;  ///< sigma [grey levels]
  /// grey level per unit of light [-]
  double gain = 1.0;
  double vignetting = 0.0;  ///< light lost in the corners, 0 to 1; grows with the square of the radius
};

/// @param stream  tells images apart: of the noise
[[nodiscard]] std::vector<std::uint8_t> develop(const std::vector<float>& light, const Camera& camera,
                                                const SensorEffects& effects, std::uint64_t stream);

}  // namespace limber
