// SPDX-License-Identifier: MIT
// limber recalibrate: a corrected calibration out of a recording.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "frame_source.hpp"
#include "interrupt.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "recalibration.hpp"
#include "recalibration_text.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "uninterrupted.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

struct RecalibrateArguments : RecordingArguments {
  fs::path out;
  bool write_anyway = false, force = false;
};

void recalibrate_dataset(const RecalibrateArguments& arguments) {
  const fs::path& calibration = arguments.calibration;
  require_replaceable_recalibration(arguments.out, arguments.force,
                                    {arguments.dataset, calibration, arguments.imu,
                                     calibration / "cam0/sensor.yaml", calibration / "cam1/sensor.yaml"});
  const ClaimedFolder claimed(arguments.out);
  const Interrupt interrupt;
  const Recording recording = open_recording(arguments);
  RecalibrateOptions options;
  options.run = to_run_options(arguments, recording);
  const FramesOf frames = [&](const Recording& of) {
    ImageFrames images = image_frames(of, arguments.frontend);
    images.frames = stoppable(std::move(images.frames));
    return images;
  };
  RecalibrationOutcome outcome;
  {
    Progress progress("recalibrate", 100);
    outcome = recalibrate(recording, options, frames, [&](std::size_t percent) {
      Interrupt::check();
      progress.done(percent);
    });
  }
  for (const std::string& note : outcome.notes) {
    print_note(note);
  }
  const RecalibrationVerdict verdict = outcome.found.verdict;
  const bool better = verdict == RecalibrationVerdict::kBetter;
  const bool write = better || arguments.write_anyway;
  {
    const Uninterrupted until_written;
    write_recalibration(arguments.out, outcome, recording, write);
  }
  for (const std::string& omission :
       write ? rig_files_left_out(outcome.found.fitted) : std::vector<std::string>()) {
    print_note(omission);
  }
  fmt::print("{}", to_text(outcome.found, recording.name, outcome.ate, write ? arguments.out.string() : ""));
  if (!better) {
    throw CLI::RuntimeError(verdict == RecalibrationVerdict::kCannotTell ? kExitUndecided : kExitKept);
  }
}

}  // namespace

void add_recalibrate_command(CLI::App& app) {
  auto arguments = std::make_shared<RecalibrateArguments>();
  CLI::App* command = app.add_subcommand(
      "recalibrate", "A corrected calibration, if the recording shows that it is a better one");
  add_recording_options(*command, *arguments);
  for (const char* name : {"--soften", "--estimate", "--false-alarms"}) {
    command->remove_option(command->get_option(name));
  }
  command->add_option("--out", arguments->out, "Folder for the calibration files and recalibration.json")
      ->required()
      ->check(not_empty());
  command->add_flag("--write-anyway", arguments->write_anyway,
                    "Write the calibration files also if the given calibration is to be kept");
  add_force_option(*command, arguments->force);
  command->footer(
      "\nWrites cam0/sensor.yaml, cam1/sensor.yaml (EuRoC), camchain.yaml, imu.yaml (Kalibr), stereo.yml "
      "(OpenCV),\n"
      "calib.txt, calib_cam_to_cam.txt (KITTI) and recalibration.json.\n"
      "Ctrl-C ends it: nothing is written, and the exit code is 1.\n"
      "Exit codes: 0 a better calibration was written; 6 the given one is kept: within tolerance, or not "
      "worse where\n"
      "it was tested; 4 cannot tell; 1 failed, 2 wrong usage. The last two never change with "
      "--write-anyway.\n"
      "Example:\n  limber recalibrate data/v101 --out mended && limber run data/v101 --calib "
      "mended/camchain.yaml "
      "--method ekf --out runs/mended");
  command->callback([arguments] { recalibrate_dataset(*arguments); });
}

}  // namespace limber::app
