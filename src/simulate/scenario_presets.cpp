// SPDX-License-Identifier: MIT
#include "limber/simulate/scenario_presets.hpp"

namespace limber {

bool are_white(const PixelScenario& pixels) {
  return pixels.per_track == 0.0 && pixels.correlated == 0.0 && pixels.field == 0.0 &&
         pixels.mismatches == 0.0;
}

bool has_wrong_points(const Scenario& scenario) {
  return !are_white(scenario.pixels) || scenario.world.moving_body.has_value();
}

void set_pixels(Scenario& scenario, PixelPreset preset) {
  scenario.pixels = {};
  scenario.noise.stated = true;
  if (preset == PixelPreset::kRealistic) {
    scenario.pixels = {.per_track = 0.3, .correlated = 0.15, .correlated_coefficient = 0.9, .field = 0.2};
    scenario.noise.pixel = 0.1;
    scenario.noise.stated = false;
    scenario.filter.gate = true;
  }
}

}  // namespace limber
