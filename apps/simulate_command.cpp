// SPDX-License-Identifier: MIT
// limber simulate: a scenario becomes a track log, or images.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "interrupt.hpp"
#include "limber/datasets/recording_place.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "parsed_by.hpp"
#include "progress.hpp"
#include "replaceable.hpp"
#include "scenario_options.hpp"
#include "uninterrupted.hpp"
#include "validators.hpp"
#ifdef LIMBER_WITH_FRONTEND
#include "limber/render/render_recording.hpp"
#endif

namespace limber::app {
namespace {

struct SimulateArguments {
  std::filesystem::path scenario, out;
  std::uint64_t seed = 0, run = 0;
  bool without_imu = false, print = false, force = false;
#ifdef LIMBER_WITH_FRONTEND
  bool images = false;
  std::string scene = "room";
  PictureOptions pictures;
#endif
  ScenarioArguments changes;
};

#ifdef LIMBER_WITH_FRONTEND
void render(const SimulateArguments& arguments, const Scenario& scenario) {
  require_place_for_recording(arguments.out, arguments.force);
  const ClaimedFolder claimed(arguments.out);
  if (!are_white(scenario.pixels)) {
    print_note("errors of pixels are for matched points; those of images come from images and tracking");
  }
  PictureOptions options = arguments.pictures;
  options.scene = scene_from_string(arguments.scene);
  const FolderUnlessEmpty parent(std::filesystem::absolute(arguments.out).lexically_normal().parent_path());
  StagedFolder staged(arguments.out);
  std::size_t pairs = 0;
  {
    const Interrupt interrupt;
    Progress progress("render", static_cast<std::size_t>(scenario.duration * scenario.stereo_rate) + 1);
    pairs = render_recording(
        scenario, arguments.seed, arguments.run, options, staged.path(),
        [&](std::size_t n) { progress.done(n); }, Interrupt::asked);
  }
  {
    const Uninterrupted until_written;
    staged.replace();
  }
  fmt::print("{}: {} pairs of images in {:.1f} s of a {}, written to {}\n", scenario.name, pairs,
             scenario.duration, arguments.scene, arguments.out.string());
}

/// Options that are numbers from 0 to `most`.
class NumberOptions {
 public:
  NumberOptions(CLI::App& command, CLI::Option* images) : command_(command), images_(images) {}

  void add(const std::string& name, double& value, int most, const std::string& description) {
    command_.add_option(name, value, description)
        ->check(number_that(fmt::format("a number from 0 to {}", most),
                            [most](double x) { return x >= 0.0 && x <= most; }))
        ->needs(images_);
  }

 private:
  CLI::App& command_;
  CLI::Option* images_;
};

void add_picture_options(CLI::App& command, SimulateArguments& arguments) {
  CLI::Option* images = command.add_flag("--images", arguments.images,
                                         "Rendered images (EuRoC folder) in place of matched points");
  command.add_option("--scene", arguments.scene, "What they show: room, hall or street")
      ->check(parsed_by(scene_from_string))
      ->needs(images)
      ->capture_default_str();
  PictureOptions& p = arguments.pictures;
  NumberOptions numbers(command, images);
  numbers.add("--image-noise", p.noise, 100, "Sigma of each pixel [grey levels]");
  command
      .add_option("--gain-difference", p.gain_difference,
                  "Share by which the right camera is darker; both swing by half of it")
      ->check(number_that("a number from 0 to 0.9", [](double x) { return x >= 0.0 && x <= 0.9; }))
      ->needs(images);
  numbers.add("--vignetting", p.vignetting, 1, "Share of the light that is lost in the corners");
  numbers.add("--exposure", p.exposure, 1, "Exposure time [s]: motion blur");
  numbers.add("--rolling-shutter", p.rolling_shutter, 1,
              "Readout time [s]: rows are exposed one after the other, the middle one at the stamp");
  command
      .add_flag("--tell-readout", p.tell_readout,
                "Write the readout time into the calibration; else estimators do not know of it")
      ->needs(command.get_option("--rolling-shutter"));
  command.add_option("--moving-objects", p.moving_objects, "Number of boxes that move through the scene")
      ->check(whole_number(0, 100))
      ->needs(images);
  numbers.add("--low-texture", p.low_texture, 1, "Share of the walls' area that is nearly plain");
  numbers.add("--dropped", p.dropped, 1, "Share of frames without the image of one of the cameras");
  numbers.add("--swapped", p.swapped, 1, "Share of frames whose left and right images are exchanged");
}
#endif

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
#ifdef LIMBER_WITH_FRONTEND
  if (arguments.images) {
    render(arguments, scenario);
    return;
  }
#endif
  require_no_run(arguments.out);
  require_place_for_mav0(arguments.out, arguments.force);
  const ClaimedFolder claimed(arguments.out);
  const Recording recording = limber::simulate(scenario, arguments.seed, arguments.run);
  {
    const Uninterrupted until_written;
    write_track_log(recording, arguments.out, arguments.force);
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
             recording.truth.landmarks.size(), arguments.out.string());
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command =
      app.add_subcommand("simulate", "Make a recording, of matched points or images, from a scenario");
  command->add_option("SCENARIO", arguments->scenario, "Scenario file (YAML), see scenarios/README.md")
      ->required()
      ->check(not_empty());
  command->add_option("--out", arguments->out, "Folder for the recording")->check(not_empty());
  command->add_option("--seed", arguments->seed, "Of everything random")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--run", arguments->run, "Which run of a Monte Carlo study")
      ->check(whole_number())
      ->capture_default_str();
  command->add_flag("--without-imu", arguments->without_imu, "Leave the IMU out, whatever the scenario says");
  add_force_option(*command, arguments->force, kEarlierRecording);
  command->add_flag("--print", arguments->print, "Print the scenario with every default filled in, and stop");
  add_scenario_options(*command, arguments->changes);
#ifdef LIMBER_WITH_FRONTEND
  add_picture_options(*command, *arguments);
#endif
  command->footer(
      "\nA track log has matched points in the place of images.\n"
      "Example:\n  limber simulate scenarios/paper_ii.yaml --seed 1 --out data/paper_ii");
  command->callback([arguments] { simulate(*arguments); });
}

}  // namespace limber::app
