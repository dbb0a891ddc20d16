// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "limber/sensors/calibration.hpp"

namespace limber {

/// @brief The rig as it was at one instant: what a StereoCalibration only assumes.
///
/// Simulators make it and evaluation reads it. No estimator takes it, but for the door of `oracle`
/// (Navigator::show_true_rig).
struct TrueRig {
  /// [ns]
  std::int64_t t_ns = 0;
  /// true, not assumed [rad, m]
  RigParameters theta = RigParameters::Zero();
};

}  // namespace limber
