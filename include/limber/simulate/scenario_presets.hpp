// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "limber/simulate/decalibration.hpp"
#include "limber/simulate/scenario.hpp"

/// Changes to a scenario that need no file of their own.
namespace limber {

/// What errors of pixels are like.
enum class PixelPreset {
  kWhite,  ///< as the paper has them
  /// As on tracks of real images: white 0.1 px, constant per track 0.3 px, AR(1) 0.15 px with 0.9 per frame,
  /// residual field of the lens 0.2 px rms, and the recording does not say so. Of the epipolar error's
  /// variance along tracks of 5 s and more 70 % are then one constant per track, its lag-1 correlation is
  /// 0.92 (KITTI: 63-76 %, 0.91-0.95).
  kRealistic
};

/// Whether pixels have white noise alone.
[[nodiscard]] bool are_white(const PixelScenario& pixels);

/// Whether some points are not where the static world says: filters should gate them.
[[nodiscard]] bool has_wrong_points(const Scenario& scenario);

/// Sets PixelScenario, NoiseScenario::stated and, for kRealistic, NoiseScenario::pixel; and that filters
/// gate, as they do with a user's recording.
void set_pixels(Scenario& scenario, PixelPreset preset);

/// @brief A fault in short: its kind, '=', and its values separated by ':' in the order of
/// scenarios/README.md, such as imu-gap=5:2, imu-spike=5:100 or right-late=0:10:0.05. The units are those of
/// scenario files.
/// @throws std::invalid_argument if it cannot be read; the message says how
[[nodiscard]] Fault fault_from_string(const std::string& text);

/// @brief A signal of decalibration in short: amplitudes by name (ax, ay, az in degrees; tx, ty, tz in m, or
/// in percent of the baseline), the shape and its keys as in scenario files, separated by commas, such as
/// "ay=0.5,tx=5%,shape=vibration,frequency=1". Without a shape it is constant.
/// @param baseline  [m]
/// @throws std::invalid_argument if it cannot be read; the message says how
[[nodiscard]] DecalibrationSignal decalibration_from_string(const std::string& text, double baseline);

}  // namespace limber
