// SPDX-License-Identifier: MIT
#include "scenario_options.hpp"

#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "parsed_by.hpp"
#include "validators.hpp"

namespace limber::app {

void add_scenario_options(CLI::App& command, ScenarioArguments& arguments) {
  command
      .add_option("--pixels", arguments.pixels,
                  "Errors of pixels, whatever the scenario says: white, or realistic (constant per track, "
                  "correlated in time, residual field of the lens; not stated in the recording)")
      ->transform(one_of({"white", "realistic"}));
  command
      .add_option("--fault", arguments.faults,
                  "Add a fault, such as imu-gap=5:2 (at 5 s, for 2 s); may be repeated. scenarios/README.md "
                  "lists them")
      ->allow_extra_args(false)
      ->check(parsed_by(fault_from_string));
}

Scenario read_scenario(const std::filesystem::path& path, const ScenarioArguments& arguments) {
  Scenario scenario = limber::read_scenario(path);
  if (!arguments.pixels.empty()) {
    set_pixels(scenario, arguments.pixels == "realistic" ? PixelPreset::kRealistic : PixelPreset::kWhite);
    scenario.name += "_" + arguments.pixels;
  }
  for (const std::string& fault : arguments.faults) {
    scenario.faults.push_back(fault_from_string(fault));
    scenario.name += "_" + fault;
  }
  return scenario;
}

}  // namespace limber::app
