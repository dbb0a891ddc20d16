// SPDX-License-Identifier: MIT
// limber health: is the calibration the problem?
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.hpp"
#include "diagnose_recording.hpp"
#include "fleet.hpp"
#include "frame_source.hpp"
#include "grouped_texts.hpp"
#include "health_since.hpp"
#include "interrupt.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/core/errors.hpp"
#include "limber/run_files/health_state.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "report_files.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

struct HealthArguments : RecordingArguments {
  std::filesystem::path out, since;
  double gravity = RunOptions{}.gravity;
  bool json = false, force = false, fleet = false;
  std::vector<std::filesystem::path> more;
  std::vector<std::string>* notes = nullptr;  ///< with --fleet they go here; nothing is printed
};

RunOptions to_options(const HealthArguments& arguments, const Recording& recording) {
  RunOptions options = to_run_options(arguments, recording);
  options.method = Method::kLcekf;
  options.gravity = arguments.gravity;
  options.doubt_odometry_mount = false;  // short motions tell most of the rig; poses are not asked for
  return options;
}

void report_run(const HealthArguments& arguments, const RunOptions& options, const RunRecord& record,
                const RunSummary& summary) {
  if (arguments.notes != nullptr) {
    *arguments.notes = record.notes;
  } else {
    for (const std::string& note : record.notes) {
      print_note(note);
    }
  }
  if (!arguments.out.empty()) {
    write_run(arguments.out, arguments.force, options, record, summary);
    make_report_beside(arguments.out);
  }
}

Diagnosis navigate(const HealthArguments& arguments, const Recording& recording, const RunOptions& options) {
  std::optional<Progress> progress;
  progress.emplace("health", frame_count(recording));
  return diagnose_recording(
      recording, options, image_frames(recording, arguments.frontend),
      [&](std::size_t n) { progress->done(n); },
      [&](const RunRecord& record, const RunSummary& summary) {
        progress.reset();
        report_run(arguments, options, record, summary);
      },
      Interrupt::asked);
}

/// Claims the folder too, until `claimed` goes.
void require_output(const HealthArguments& arguments, std::deque<ClaimedFolder>& claimed) {
  if (arguments.out.empty()) {
    return;
  }
  std::error_code ignored;
  if (!arguments.since.empty() && std::filesystem::equivalent(arguments.out / kHealthStateName,
                                                              health_state_file(arguments.since), ignored)) {
    throw DataError(arguments.out.string(), 0, "another folder than that of --since", "the same");
  }
  require_replaceable_run(arguments.out, arguments.force);
  claimed.emplace_back(arguments.out);
}

/// Of one recording, with all that is to be written of it.
Diagnosis diagnose(const HealthArguments& arguments) {
  const Recording recording = open_recording(arguments);
  const RunOptions options = to_options(arguments, recording);
  std::optional<HealthState> before;
  if (!arguments.since.empty()) {
    before = earlier_state(arguments.since, corrected(recording.calibration, options.assume_error));
  }
  Diagnosis diagnosis = navigate(arguments, recording, options);
  diagnosis.since = since_then(before, diagnosis);
  if (!arguments.out.empty() && diagnosis.state) {
    write_health_state(arguments.out / kHealthStateName, *diagnosis.state);
  }
  return diagnosis;
}

/// In DIR/01-NAME, DIR/02-NAME, ...
HealthArguments member(const HealthArguments& fleet, std::size_t n) {
  HealthArguments one = fleet;
  one.dataset = n == 0 ? fleet.dataset : fleet.more[n - 1];
  if (!fleet.out.empty()) {
    const std::filesystem::path name = (one.dataset / "").parent_path().filename();
    one.out = fleet.out / fmt::format("{:02}-{}", n + 1, name.string());
  }
  return one;
}

/// Each note once, with the recordings that it is of unless it is of all.
void print_fleet_notes(const std::vector<FleetRow>& rows,
                       const std::map<std::string, std::vector<std::string>>& notes) {
  std::vector<std::string> names;
  for (const FleetRow& row : rows) {
    if (std::find(names.begin(), names.end(), row.dataset) == names.end()) {
      names.push_back(row.dataset);
    }
  }
  for (const auto& [note, of] : by_text(names, notes)) {
    print_note(of.size() == names.size() ? note : fmt::format("{}: {}", fmt::join(of, ", "), note));
  }
}

int fleet(const HealthArguments& arguments) {
  std::deque<ClaimedFolder> claimed;
  for (std::size_t n = 0; n <= arguments.more.size(); ++n) {
    require_output(member(arguments, n), claimed);
  }
  std::vector<FleetRow> rows;
  std::map<std::string, std::vector<std::string>> notes;
  for (std::size_t n = 0; n <= arguments.more.size(); ++n) {
    HealthArguments one = member(arguments, n);
    one.notes = &notes[one.dataset.string()];
    rows.push_back({one.dataset.string(), std::nullopt, ""});
    if (Interrupt::asked()) {
      rows.back().stopped = true;
      continue;
    }
    try {
      rows.back().diagnosis = diagnose(one);
    } catch (const CLI::Error&) {  // wrong for every recording
      throw;
    } catch (const std::runtime_error& error) {  // the others are judged nevertheless
      rows.back().stopped = Interrupt::asked();
      rows.back().failure = rows.back().stopped ? "" : error.what();
    } catch (const std::invalid_argument& error) {  // an option that does not fit this rig
      rows.back().failure = error.what();
    }
  }
  if (arguments.since.empty()) {
    compare_with_first(rows);
  }
  print_fleet_notes(rows, notes);
  fmt::print("{}", arguments.json ? fleet_json(rows) : fleet_text(rows));
  return fleet_exit_code(rows);
}

void health(const HealthArguments& arguments) {
  if (!arguments.fleet && !arguments.more.empty()) {
    throw CLI::ValidationError("MORE", "several recordings: --fleet judges them all");
  }
  const Interrupt interrupt;
  int code = kExitDone;
  if (arguments.fleet) {
    code = fleet(arguments);
  } else {
    std::deque<ClaimedFolder> claimed;
    require_output(arguments, claimed);
    const Diagnosis diagnosis = diagnose(arguments);
    fmt::print("{}", arguments.json ? to_json(diagnosis) : to_text(diagnosis));
    code = diagnosis.stopped ? kExitFailed : exit_code(verdict_of(diagnosis));
  }
  if (code != kExitDone) {
    throw CLI::RuntimeError(code);
  }
}

void add_options(CLI::App& command, HealthArguments& arguments) {
  add_recording_options(command, arguments);
  command.add_option("MORE", arguments.more, "More recordings, with --fleet");
  command.add_flag("--fleet", arguments.fleet,
                   "A table of all recordings, a row each, and how each rig moved since the first with the "
                   "same cameras; the exit code of the worst");
  command.add_option("--gravity", arguments.gravity, "At the place of the recording [m/s^2]")
      ->check(positive())
      ->capture_default_str();
  command.add_option("--out", arguments.out, "Keep the run's files and its report in this folder")
      ->check(not_empty());
  command
      .add_option("--since", arguments.since,
                  "What moved since an earlier recording: the folder that health wrote for it (--out), or "
                  "its health_state.json")
      ->check(CLI::ExistingPath);
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
      "Ctrl-C ends it early: what was seen by then is judged and marked as partial, no health_state.json is "
      "written,\n"
      "of a fleet the rest is not judged, and the exit code is 1.\n"
      "Exit codes: 0 ok, 3 decalibrated, 4 cannot tell, 5 degraded; 1 failed, 2 wrong usage.\n"
      "Example:\n  limber health data/v101 --false-alarms 0.1 --out runs/v101-health\n"
      "  limber health data/v102 --since runs/v101-health\n"
      "  limber health data/monday data/tuesday data/wednesday --fleet");
  command->callback([arguments] { health(*arguments); });
}

}  // namespace limber::app
