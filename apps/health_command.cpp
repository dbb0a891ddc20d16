// SPDX-License-Identifier: MIT
// limber health: is the calibration the problem?
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "commands.hpp"
#include "diagnose_recording.hpp"
#include "frame_source.hpp"
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

void report_run(const HealthArguments& arguments, const RunOptions& options, const RunRecord& record,
                const RunSummary& summary) {
  for (const std::string& note : record.notes) {
    print_note(note);
  }
  if (!arguments.out.empty()) {
    {
      const Uninterrupted until_written;
      write_run_output(arguments.out, options, record, summary);
    }
    make_report_beside(arguments.out);
  }
}

Diagnosis diagnose(const HealthArguments& arguments, const Recording& recording, const RunOptions& options) {
  std::optional<Progress> progress;
  progress.emplace("health", frame_count(recording));
  return diagnose_recording(
      recording, options, image_frames(recording, arguments.frontend).frames,
      [&](std::size_t n) { progress->done(n); },
      [&](const RunRecord& record, const RunSummary& summary) {
        progress.reset();
        report_run(arguments, options, record, summary);
      });
}

void health(const HealthArguments& arguments) {
  const Recording recording = open_recording(arguments);
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
      "\nNavigates with lcekf, which no calibration can lead astray, estimates how wrong the calibration is, "
      "and\n"
      "compares the 95 % interval of that with the tolerance. Also recognises swapped cameras, inverted "
      "transforms, a wrong\n"
      "resolution and clocks that disagree.\n"
      "Exit codes: 0 ok, 3 decalibrated, 4 cannot tell, 5 degraded; 1 failed, 2 wrong usage.\n"
      "Example:\n  limber health data/v101 --false-alarms 0.1 --out runs/v101-health");
  command->callback([arguments] { health(*arguments); });
}

}  // namespace limber::app
