// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "limber/simulate/scenario.hpp"

/// What commands may change of a scenario without another file.
namespace limber::app {

struct ScenarioArguments {
  std::string pixels;  ///< empty: as the scenario says
  std::vector<std::string> faults;
};

void add_scenario_options(CLI::App& command, ScenarioArguments& arguments);

/// @brief Reads a scenario and changes it; its name says how, so that a study tells the two apart.
[[nodiscard]] Scenario read_scenario(const std::filesystem::path& path, const ScenarioArguments& arguments);

}  // namespace limber::app
