// SPDX-License-Identifier: MIT
// limber simulate: a scenario becomes a track log.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "scenario_options.hpp"
#include "uninterrupted.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

struct SimulateArguments {
  std::filesystem::path scenario, out;
  std::uint64_t seed = 0, run = 0;
  bool without_imu = false, print = false;
  ScenarioArguments changes;
};

void simulate(const SimulateArguments& arguments) {
  Scenario scenario = read_scenario(arguments.scenario, arguments.changes);
  if (arguments.without_imu) {
    scenario.use_imu = false;
  }
  if (arguments.print) {
    fmt::print("{}", format_scenario(scenario));
    return;
  }
  if (arguments.out.empty()) {
    throw CLI::RequiredError("--out");
  }
  require_writable_folder(arguments.out);
  const Recording recording = limber::simulate(scenario, arguments.seed, arguments.run);
  {
    const Uninterrupted until_written;
    write_track_log(recording, arguments.out);
  }
  std::size_t points = 0;
  for (const StereoFrame& frame : recording.frames) {
    points += frame.observations.size();
  }
  if (points == 0) {
    print_warning("no camera sees any point: compare world, rig and trajectory in " +
                  arguments.scenario.string());
  }
  fmt::print("{}: {} frames in {:.1f} s, {:.1f} points a frame, {} landmarks, written to {}\n", scenario.name,
             recording.frames.size(), scenario.duration,
             static_cast<double>(points) / static_cast<double>(recording.frames.size()),
             recording.landmarks_true.size(), arguments.out.string());
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "Make a recording (track log) from a scenario");
  command->add_option("SCENARIO", arguments->scenario, "Scenario file (YAML), see scenarios/README.md")
      ->required()
      ->check(not_empty());
  command->add_option("--out", arguments->out, "Folder for the track log")->check(not_empty());
  command->add_option("--seed", arguments->seed, "Of everything random")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--run", arguments->run, "Which run of a Monte Carlo study")
      ->check(whole_number())
      ->capture_default_str();
  command->add_flag("--without-imu", arguments->without_imu, "Leave the IMU out, whatever the scenario says");
  command->add_flag("--print", arguments->print, "Print the scenario with every default filled in, and stop");
  add_scenario_options(*command, arguments->changes);
  command->footer("\nExample:\n  limber simulate scenarios/paper_ii.yaml --seed 1 --out data/paper_ii");
  command->callback([arguments] { simulate(*arguments); });
}

}  // namespace limber::app
