// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "source_folder.hpp"

namespace limber::testing {

/// One of scenarios/.
/// @param duration  [s], if not the file's
/// @param pixels  if not the file's
inline Scenario shipped(const std::string& name, std::optional<double> duration = {},
                        std::optional<PixelPreset> pixels = {}) {
  Scenario scenario = read_scenario(source_folder() / "scenarios" / (name + ".yaml"));
  if (duration) {
    scenario.duration = *duration;
  }
  if (pixels) {
    set_pixels(scenario, *pixels);
  }
  return scenario;
}

/// The first seconds of one of scenarios/, with pixels as tracks of real images have them.
inline Recording realistic(const std::string& name, double duration, std::uint64_t seed) {
  return simulate(shipped(name, duration, PixelPreset::kRealistic), seed);
}

}  // namespace limber::testing
