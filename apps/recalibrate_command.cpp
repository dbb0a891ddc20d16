// SPDX-License-Identifier: MIT
// limber recalibrate: a corrected calibration out of a recording.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "frame_source.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "limber/run/recalibrate_recording.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "recalibration_text.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "uninterrupted.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

struct RecalibrateArguments : RecordingArguments {
  std::filesystem::path out;
  bool write_anyway = false, force = false;
};

constexpr std::string_view kRecalibrationMark = "\"recalibration\"";

/// Nothing is replaced but what an earlier recalibration wrote, and nothing that this one reads.
void require_replaceable_results(const RecalibrateArguments& arguments) {
  const std::filesystem::path& calibration = arguments.calibration;
  const std::vector<std::filesystem::path> inputs = {arguments.dataset, calibration, arguments.imu,
                                                     calibration / "cam0/sensor.yaml",
                                                     calibration / "cam1/sensor.yaml"};
  const std::filesystem::path report = arguments.out / kRecalibrationFile;
  require_replaceable(report, kRecalibrationMark, arguments.force, inputs);
  const std::string_view mark = std::filesystem::exists(report) ? "" : kRecalibrationMark;
  for (const std::string& name : rig_file_names()) {
    require_replaceable(arguments.out / name, mark, arguments.force, inputs);
  }
}

/// ATE of ekf with either calibration, where there is a truth to measure it by.
std::optional<BeforeAfter> ate_of(const Recording& recording, const RunOptions& run,
                                  const Recalibration& found) {
  if (recording.groundtruth.empty()) {
    return std::nullopt;
  }
  RunOptions options = run;
  options.method = Method::kEkf;
  options.assume_error.setZero();
  std::vector<double> ates;
  for (const StereoCalibration* calibration : {&found.given, &found.fitted}) {
    Recording with = recording;
    with.calibration = *calibration;
    try {
      const RunRecord record = run_recording(with, options, frame_source(with));
      const auto ate = summarize(with, options, record).ate_se3_m;
      if (!ate) {
        return std::nullopt;
      }
      ates.push_back(*ate);
    } catch (const std::exception& error) {
      print_note(fmt::format("ekf with the {} calibration fails: {}", ates.empty() ? "given" : "corrected",
                             error.what()));
      return std::nullopt;
    }
  }
  return BeforeAfter{ates[0], ates[1]};
}

void write_results(const RecalibrateArguments& arguments, const Recording& recording,
                   const Recalibration& found, const std::optional<BeforeAfter>& ate, bool write) {
  const Uninterrupted until_written;
  std::filesystem::create_directories(arguments.out);
  std::vector<std::string> files;
  if (write) {
    files = write_rig_files(arguments.out, found.fitted, recording.imu_noise);
  }
  write_file_atomically(arguments.out / kRecalibrationFile, to_json(found, recording.name, ate, files));
}

void recalibrate(const RecalibrateArguments& arguments) {
  const Recording recording = open_recording(arguments);
  RecalibrateOptions options;
  options.run = to_run_options(arguments, recording);
  require_replaceable_results(arguments);
  require_writable_folder(arguments.out);
  const FrameSource frames = frame_source(recording);
  Recalibration found;
  {
    Progress progress("recalibrate", 100);
    found = recalibrate_recording(recording, options, frames,
                                  [&](std::size_t percent) { progress.done(percent); });
  }
  for (const std::string& note : found.notes) {
    print_note(note);
  }
  const auto ate = ate_of(recording, options.run, found);
  const bool better = found.verdict == RecalibrationVerdict::kBetter;
  const bool write = better || arguments.write_anyway;
  write_results(arguments, recording, found, ate, write);
  fmt::print("{}", to_text(found, recording.name, ate, write ? arguments.out.string() : ""));
  if (!better) {
    throw CLI::RuntimeError(found.verdict == RecalibrationVerdict::kCannotTell ? kExitUndecided : kExitKept);
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
      "Exit codes: 0 a better calibration was written; 6 the given one is kept: within tolerance, or not "
      "worse where\n"
      "it was tested; 4 cannot tell; 1 failed, 2 wrong usage. The last two never change with "
      "--write-anyway.\n"
      "Example:\n  limber recalibrate data/v101 --out mended && limber run data/v101 --calib "
      "mended/camchain.yaml "
      "--method ekf --out runs/mended");
  command->callback([arguments] { recalibrate(*arguments); });
}

}  // namespace limber::app
