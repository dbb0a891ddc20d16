// SPDX-License-Identifier: MIT
#include "pixel_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace limber::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLeastOrder = 2, kLargestOrder = 4;

/// Mean of cos^2(pi m x) over x in [0, 1].
double mean_square(int m) { return m == 0 ? 1.0 : 0.5; }

}  // namespace

LensField::LensField(const Camera& camera, double rms, const RandomStream& random)
    : width_(camera.width), height_(camera.height) {
  Vector2d variance = Vector2d::Zero();
  for (int m = 0; m <= kLargestOrder; ++m) {
    for (int n = std::max(0, kLeastOrder - m); m + n <= kLargestOrder; ++n) {
      const Vector2d amplitude = random.normal2(static_cast<std::uint64_t>(m), static_cast<std::uint32_t>(n));
      variance += mean_square(m) * mean_square(n) * amplitude.cwiseAbs2();
      modes_.push_back({m, n, amplitude});
    }
  }
  for (Mode& mode : modes_) {
    mode.amplitude.array() *= rms / variance.array().sqrt();
  }
}

Vector2d LensField::at(const Vector2d& uv) const {
  Vector2d error = Vector2d::Zero();
  for (const Mode& mode : modes_) {
    error += std::cos(std::numbers::pi * mode.m * uv.x() / width_) *
             std::cos(std::numbers::pi * mode.n * uv.y() / height_) * mode.amplitude;
  }
  return error;
}

PixelErrors::PixelErrors(const Scenario& scenario, std::size_t points, std::uint64_t seed, std::uint64_t run)
    : scenario_(scenario),
      mismatch_(seed, run, "mismatch"),
      place_(seed, run, "mismatch_place"),
      lenses_{lens(scenario.rig.cam0, "cam0", points, seed, run),
              lens(scenario.rig.cam1, "cam1", points, seed, run)} {}

PixelErrors::Lens PixelErrors::lens(const Camera& camera, const std::string& name, std::size_t points,
                                    std::uint64_t seed, std::uint64_t run) const {
  const std::uint64_t field_run = scenario_.same_world_in_all_runs ? 0 : run;
  Lens lens{LensField(camera, scenario_.pixels.field, RandomStream(seed, field_run, "lens_field_" + name)),
            RandomStream(seed, run, "pixel_per_track_" + name),
            RandomStream(seed, run, "pixel_correlated_" + name),
            {}};
  for (std::size_t id = 0; id < points; ++id) {
    lens.state.push_back(lens.correlated.normal2(id, 0));
  }
  return lens;
}

void PixelErrors::advance_to(std::uint32_t j) {
  const double a = scenario_.pixels.correlated_coefficient;
  for (; frame_ < j; ++frame_) {
    for (Lens& lens : lenses_) {
      for (std::size_t id = 0; id < lens.state.size(); ++id) {
        lens.state[id] =
            a * lens.state[id] + std::sqrt(1.0 - a * a) * lens.correlated.normal2(id, frame_ + 1);
      }
    }
  }
}

Vector2d PixelErrors::at(std::size_t camera, std::size_t id, const Vector2d& uv) const {
  const Lens& lens = lenses_[camera];
  const PixelScenario& pixels = scenario_.pixels;
  return pixels.per_track * lens.per_track.normal2(id) + pixels.correlated * lens.state[id] +
         lens.field.at(uv);
}

void PixelErrors::mismatch(StereoFrame& frame) const {
  if (scenario_.pixels.mismatches == 0.0) {
    return;
  }
  const std::vector<StereoObservation> seen = frame.observations;
  for (StereoObservation& o : frame.observations) {
    const auto id = static_cast<std::uint64_t>(o.track_id);
    if (mismatch_.uniform(id, frame_) >= scenario_.pixels.mismatches) {
      continue;
    }
    const Vector3d how = place_.uniform3(id, frame_);
    const bool right = o.in_cam1 && how.x() < 0.5;
    const Camera& camera = right ? scenario_.rig.cam1 : scenario_.rig.cam0;
    Vector2d& uv = right ? o.uv_cam1 : o.uv_cam0;
    // One number in (0, 1) says which: below 0.5 a random place, above it another point.
    const auto other =
        static_cast<std::size_t>(std::max(2.0 * how.y() - 1.0, 0.0) * static_cast<double>(seen.size()));
    if (how.y() > 0.5 && seen[other].track_id != o.track_id && (!right || seen[other].in_cam1)) {
      uv = right ? seen[other].uv_cam1 : seen[other].uv_cam0;
    } else {
      const Vector2d place(2.0 * how.y(), how.z());
      uv = (place - place.array().floor().matrix()).cwiseProduct(Vector2d(camera.width, camera.height));
    }
  }
}

}  // namespace limber::detail
