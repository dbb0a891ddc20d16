// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "limber/sensors/calibration.hpp"

namespace limber {

/// Noise of a step in a gap between samples grows with the gap (InputStep::gap).
[[nodiscard]] inline ImuNoise inflated(ImuNoise noise, double gap) {
  noise.gyro_density *= std::sqrt(gap);
  noise.accel_density *= std::sqrt(gap);
  return noise;
}

/// Per-sample noise as it acts over a step of dt [s]: white, so that its variance goes with the sample
/// interval [s] over dt.
[[nodiscard]] inline OdometryNoise per_step(OdometryNoise noise, double sample_interval, double dt,
                                            double gap) {
  const double factor = std::sqrt(gap * (sample_interval > 0.0 ? sample_interval / dt : 1.0));
  noise.sigma_v *= factor;
  noise.sigma_omega *= factor;
  return noise;
}

}  // namespace limber
