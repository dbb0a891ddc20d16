// SPDX-License-Identifier: MIT
// limber health: is the calibration the problem?
#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "diagnosis.hpp"
#include "frame_source.hpp"
#include "limber/diagnose/calibration_mistakes.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/run_files/run_output.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "report_files.hpp"
#include "uninterrupted.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

struct HealthArguments : RecordingArguments {
  std::filesystem::path out;
  double gravity = RunOptions{}.gravity;
  bool json = false, force = false;
};

RunOptions to_options(const HealthArguments& arguments, const Recording& recording) {
  RunOptions options = to_run_options(arguments, recording);
  options.method = Method::kLcekf;
  options.gravity = arguments.gravity;
  return options;
}

void write_results(const HealthArguments& arguments, const RunOptions& options, const RunRecord& record,
                   const RunSummary& summary) {
  {
    const Uninterrupted until_written;
    write_run_output(arguments.out, options, record, summary);
  }
  make_report_beside(arguments.out);
}

/// The run, as far as it comes; `seen` holds the frames it looked at.
void watch(const HealthArguments& arguments, const Recording& recording, const RunOptions& options,
           std::vector<StereoFrame>& seen, Diagnosis& diagnosis) {
  const FrameSource frames = frame_source(recording);
  const FrameSource remembered = [&](std::size_t n) {
    seen.push_back(frames(n));
    return seen.back();
  };
  RunRecord record;
  {
    Progress progress("health", frame_count(recording));
    record = run_recording(recording, options, remembered, [&](std::size_t n) { progress.done(n); });
  }
  const RunSummary summary = summarize(recording, options, record);
  diagnosis.frames = summary.frames;
  diagnosis.duration_s = summary.duration_s;
  diagnosis.nis_per_dof = summary.nis_per_dof;
  diagnosis.health = summary.health;
  for (const std::string& note : record.notes) {
    print_note(note);
  }
  if (!arguments.out.empty()) {
    write_results(arguments, options, record, summary);
  }
}

Diagnosis diagnose(const HealthArguments& arguments, const Recording& recording, const RunOptions& options) {
  Diagnosis out;
  out.dataset = recording.name;
  out.false_alarms_per_hour = options.false_alarms_per_hour;
  const StereoCalibration assumed = corrected(recording.calibration, options.assume_error);
  std::vector<StereoFrame> seen;
  try {
    watch(arguments, recording, options, seen, out);
    out.mistakes = calibration_mistakes(assumed, seen);
  } catch (const std::exception& error) {
    // A gross mistake may leave nothing to navigate with: then it is the answer.
    out.mistakes = calibration_mistakes(assumed, seen);
    if (out.mistakes.empty()) {
      throw;
    }
    out.failure = error.what();
  }
  if (out.health) {
    out.depths = depth_effects(assumed.theta, out.health->since_change);
  }
  if (out.mistakes.empty()) {
    out.cam1_offset = cam1_time_offset(assumed, seen);
    out.camera_offset = camera_time_offset(assumed, seen, recording.imu);
  }
  return out;
}

void health(const HealthArguments& arguments) {
  const Recording recording = read_recording(arguments);
  const RunOptions options = to_options(arguments, recording);
  if (!arguments.out.empty()) {
    require_replaceable_run(arguments.out, arguments.force);
    require_writable_folder(arguments.out);
  }
  const Diagnosis diagnosis = diagnose(arguments, recording, options);
  fmt::print("{}", arguments.json ? to_json(diagnosis) : to_text(diagnosis));
  const int code = exit_code(verdict_of(diagnosis));
  if (code != kExitDone) {
    throw CLI::RuntimeError(code);
  }
}

void add_options(CLI::App& command, HealthArguments& arguments) {
  add_recording_options(command, arguments);
  command.add_option("--gravity", arguments.gravity, "At the place of the recording [m/s^2]")
      ->check(positive())
      ->capture_default_str();
  command.add_option("--out", arguments.out, "Keep the run's files and its report in this folder")
      ->check(not_empty());
  command.add_flag("--json", arguments.json, "Print JSON instead of text");
}

}  // namespace

void add_health_command(CLI::App& app) {
  auto arguments = std::make_shared<HealthArguments>();
  CLI::App* command =
      app.add_subcommand("health", "Is the calibration the problem? What moved, and since when");
  add_options(*command, *arguments);
  add_force_option(*command, arguments->force);
  command->footer(
      "\nNavigates with lcekf, which no calibration can lead astray, and watches what the right camera says\n"
      "against the assumed calibration. Also recognises swapped cameras, inverted transforms, a wrong\n"
      "resolution and clocks that disagree.\n"
      "Exit codes: 0 ok, 3 decalibrated, 4 cannot tell, 5 suspect; 1 failed, 2 wrong usage.\n"
      "Example:\n  limber health data/v101 --false-alarms 0.1 --out runs/v101-health");
  command->callback([arguments] { health(*arguments); });
}

}  // namespace limber::app
