// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "limber/core/random.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/simulate/scenario.hpp"

/// What pixels have beyond white noise (PixelScenario).
namespace limber::detail {

/// @brief Smooth residual of a lens model: u and v each a sum of cos(pi m x) cos(pi n y) with 2 <= m + n <=
/// 4, x and y from 0 to 1 over the image. Offset and slopes are left out, which a calibration takes along.
class LensField {
 public:
  /// @param rms of each of u and v over the image [px]
  LensField(const Camera& camera, double rms, const RandomStream& random);

  [[nodiscard]] Eigen::Vector2d at(const Eigen::Vector2d& uv) const;

 private:
  struct Mode {
    int m = 0, n = 0;
    Eigen::Vector2d amplitude;  // [px]
  };
  double width_, height_;
  std::vector<Mode> modes_;
};

/// @brief The errors of both cameras' pixels, frame by frame.
class PixelErrors {
 public:
  PixelErrors(const Scenario& scenario, std::size_t points, std::uint64_t seed, std::uint64_t run);

  /// Goes on to frame `j`: AR(1) errors go on in every frame, whether points are seen or not.
  void advance_to(std::uint32_t j);

  /// Error of point `id` in camera 0 or 1, in the current frame, where the true pixel is `uv` [px].
  [[nodiscard]] Eigen::Vector2d at(std::size_t camera, std::size_t id, const Eigen::Vector2d& uv) const;

  /// Moves the pixels of mismatched points of the current frame.
  void mismatch(StereoFrame& frame) const;

 private:
  struct Lens {
    LensField field;
    RandomStream per_track, correlated;
    std::vector<Eigen::Vector2d> state;  // of AR(1), by point; unit variance
  };

  [[nodiscard]] Lens lens(const Camera& camera, const std::string& name, std::size_t points,
                          std::uint64_t seed, std::uint64_t run) const;

  const Scenario& scenario_;
  RandomStream mismatch_, place_;
  std::array<Lens, 2> lenses_;
  std::uint32_t frame_ = 0;
};

}  // namespace limber::detail
