// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "limber/core/random.hpp"
#include "limber/core/time.hpp"
#include "limber/simulate/simulator.hpp"

namespace limber::testing {

/// Where a point is between frames: on the cubic through its pixels in four of them, the second of which is
/// the one asked about. Each as (t [s], u0, v0, u1, v1).
using FourViews = std::array<Eigen::Matrix<double, 5, 1>, 4>;

inline Eigen::Vector4d pixels_at(const FourViews& views, double t) {
  Eigen::Vector4d out = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < 4; ++j) {
      weight *= j == i ? 1.0 : (t - views[j](0)) / (views[i](0) - views[j](0));
    }
    out += weight * views[i].tail<4>();
  }
  return out;
}

/// @brief The track log of cameras that expose their rows one after the other, and of a world as in the
/// scenario, with its pixel noise. Points are seen where both cameras see them in the frame before and the
/// two after as well.
inline Recording with_rolling_rows(Scenario scenario, double readout_s, std::uint64_t seed) {
  const double sigma = scenario.noise.pixel;
  scenario.noise.pixel = 1e-9;
  Recording recording = simulate(scenario, seed);
  recording.pixel_noise = PixelNoise::Constant(sigma);
  const std::vector<StereoFrame> given = recording.frames;
  std::vector<std::map<std::int64_t, Eigen::Matrix<double, 5, 1>>> seen(given.size());
  for (std::size_t n = 0; n < given.size(); ++n) {
    for (const StereoObservation& o : given[n].observations) {
      if (o.in_cam0 && o.in_cam1) {
        seen[n][o.track_id] << seconds_between(given[0].t_ns, given[n].t_ns), o.uv_cam0, o.uv_cam1;
      }
    }
  }
  const RandomStream noise(seed, 0, "rolling rows");
  std::uint64_t draws = 0;
  for (std::size_t n = 0; n < given.size(); ++n) {
    recording.frames[n].observations.clear();
    for (const auto& [id, view] : seen[n]) {
      if (n == 0 || n + 2 >= given.size() || !seen[n - 1].contains(id) || !seen[n + 1].contains(id) ||
          !seen[n + 2].contains(id)) {
        continue;
      }
      const FourViews views = {seen[n - 1][id], view, seen[n + 1][id], seen[n + 2][id]};
      StereoObservation o{id, view.segment<2>(1), view.segment<2>(3)};
      for (int k = 0; k < 10; ++k) {  // the row says when, and when says the row
        o.uv_cam0 =
            pixels_at(views, view(0) + row_delay(recording.calibration.cam0, readout_s, o.uv_cam0.y()))
                .head<2>();
        o.uv_cam1 =
            pixels_at(views, view(0) + row_delay(recording.calibration.cam1, readout_s, o.uv_cam1.y()))
                .tail<2>();
      }
      o.uv_cam0 += sigma * noise.normal2(draws++);
      o.uv_cam1 += sigma * noise.normal2(draws++);
      if (in_image(recording.calibration.cam0, o.uv_cam0) &&
          in_image(recording.calibration.cam1, o.uv_cam1)) {
        recording.frames[n].observations.push_back(o);
      }
    }
  }
  return recording;
}

}  // namespace limber::testing
