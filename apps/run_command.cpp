// SPDX-License-Identifier: MIT
// limber run: navigate through a recording.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.hpp"
#include "frame_source.hpp"
#include "interrupt.hpp"
#include "limber/core/errors.hpp"
#include "limber/run_files/run_output.hpp"
#include "live_view.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "parsed_by.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "report_files.hpp"
#include "run_methods.hpp"
#include "run_summary_text.hpp"
#include "validators.hpp"
#include "watched_frames.hpp"

namespace limber::app {
namespace {

struct RunArguments : RecordingArguments {
  std::filesystem::path out;
  std::string method = "lcekf", constraints, landmarks = "inverse-depth", gate = "on";
  std::size_t max_landmarks = 300;
  std::optional<std::size_t> points_per_update;
  std::uint64_t seed = 0, run = 0;
  bool force = false;
  ViewArguments view;
  std::vector<std::string> methods;
  std::vector<std::string>* notes = nullptr;  ///< with --methods they go here; nothing is printed
  /// mistakes that were said when they were seen; with --methods of all methods
  std::shared_ptr<std::set<std::string>> said = std::make_shared<std::set<std::string>>();
};

RunOptions to_options(const RunArguments& arguments, const Recording& recording) {
  RunOptions options = to_run_options(arguments, recording);
  options.method = method_from_string(arguments.method);
  if (!arguments.constraints.empty()) {
    if (options.method != Method::kLcekf) {
      throw CLI::ValidationError("--constraints", "lcekf alone has constraints, not " + arguments.method);
    }
    options.constraints = constraint_set_from_string(arguments.constraints);
  }
  options.landmarks =
      arguments.landmarks == "cartesian" ? LandmarkKind::kCartesian : LandmarkKind::kInverseDepth;
  options.gate = arguments.gate == "on";
  options.max_landmarks = arguments.max_landmarks;
  options.points_per_update = arguments.points_per_update;
  options.seed = arguments.seed;
  options.run = arguments.run;
  return options;
}

/// What the progress bar says of the latest pair of images.
std::string timing_text(const FrontendRecord* frontend) {
  if (frontend == nullptr || frontend->t_ns.empty()) return "";
  return fmt::format("decode {:.1f} ms, track {:.1f} ms", frontend->decode_ms.back(),
                     frontend->track_ms.back());
}

/// But for those that were said before.
void print_notes(const std::vector<std::string>& notes, const std::set<std::string>& said) {
  for (const std::string& note : notes) {
    if (!said.contains(note)) print_note(note);
  }
}

/// Before a long run, not after it: whether the page of --view-out can be written.
void require_place_of_page(const RunArguments& arguments) {
  namespace fs = std::filesystem;
  const fs::path& page = arguments.view.page;
  if (page.empty()) return;
  const auto place = [](const fs::path& path) { return (fs::absolute(path) / "").lexically_normal(); };
  std::vector<std::string> names = run_file_names();
  names.emplace_back("report.html");
  if (std::ranges::any_of(
          names, [&](const std::string& name) { return place(page) == place(arguments.out / name); })) {
    throw CLI::ValidationError("--view-out", page.string() + " is the name of one of the run's results");
  }
  require_replaceable(page, kPageMark, arguments.force, {arguments.dataset});
  const fs::path folder = fs::absolute(page).parent_path();
  if (place(folder) != place(arguments.out) && !fs::is_directory(folder)) {
    throw DataError(page.string(), 0, "a file in a folder that is there", "no folder " + folder.string());
  }
}

/// run_recording with what the command shows meanwhile; `watched` are the frames of `source`.
RunRecord run_and_show(const Recording& recording, const RunOptions& options, const ImageFrames& source,
                       LiveView* view, WatchedFrames& watched, SharedStarts* starts) {
  Progress progress(to_string(options.method), frame_count(recording));
  RunCallbacks callbacks;
  callbacks.progress = [&](std::size_t n) { progress.done(n, timing_text(source.record.get())); };
  callbacks.stop = Interrupt::asked;
  callbacks.wait = [&](const WaitingFrame& frame) {
    progress.done(frame.number, "start: " + frame.report.missing);
    if (view != nullptr) view->show(frame);
  };
  if (view != nullptr) {
    callbacks.observe = [view](const ObservedFrame& frame) { view->show(frame); };
  }
  try {
    RunRecord record = run_recording(recording, options, watched.frames(), callbacks, starts);
    watched.complete(record);
    if (view != nullptr) record.elapsed_s -= view->held_s();
    return record;
  } catch (const std::exception& error) {
    watched.finish();
    if (view != nullptr) view->finish(error.what());
    throw;
  }
}

void run_on(const Recording& recording, const RepeatedFrames& frames, const RunArguments& arguments,
            SharedStarts* starts = nullptr) {
  const RunOptions options = to_options(arguments, recording);
  const ImageFrames source = frames();
  const std::unique_ptr<LiveView> view =
      open_live_view(arguments.view, recording, options, source.record, Interrupt::asked);
  WatchedFrames watched(recording, options, source, [&](const std::string& mistake) {
    if (arguments.said->insert(mistake).second) print_warning(mistake);
  });
  RunRecord record = run_and_show(recording, options, source, view.get(), watched, starts);
  if (record.frames.empty()) {
    throw std::runtime_error("stopped before the first frame: nothing is written");
  }
  const RunSummary summary = watched.judge(record);
  write_run(arguments.out, arguments.force, options, record, summary);
  if (arguments.notes != nullptr) {
    *arguments.notes = record.notes;
  } else {
    print_notes(record.notes, *arguments.said);
    print_run_summary(options, record, summary, arguments.out);
  }
  make_report_beside(arguments.out);
  if (view) {
    view->finish(fmt::format("{} {} of {} frames; results in {}", record.stopped ? "Stopped after" : "Done:",
                             record.frames.size(), record.frames_of_recording, arguments.out.string()));
    if (!record.stopped) view->stay();
  }
  if (!record.is_complete() || !is_trustworthy(summary)) {
    throw CLI::RuntimeError(kExitFailed);  // the notes say why
  }
}

void run(const RunArguments& arguments) {
  require_replaceable_run(arguments.out, arguments.force);
  const ClaimedFolder claimed(arguments.out);
  require_place_of_page(arguments);
  const Interrupt interrupt;
  const Recording recording = open_recording(arguments);
  run_on(
      recording, [&] { return image_frames(recording, arguments.frontend); }, arguments);
}

/// The recording is opened, and its images are read and tracked, once.
void run_each(const RunArguments& arguments) {
  const std::vector<std::string> methods = different_methods(arguments.methods);
  const std::string lcekf = to_string(Method::kLcekf);
  if (!arguments.constraints.empty() && std::find(methods.begin(), methods.end(), lcekf) == methods.end()) {
    throw CLI::ValidationError("--constraints", "lcekf alone has constraints, which --methods does not name");
  }
  std::optional<Recording> recording;
  RepeatedFrames frames;
  SharedStarts starts;
  run_methods(
      methods, arguments.out, arguments.force,
      [&](const std::string& method, const std::filesystem::path& folder, std::vector<std::string>& notes) {
        RunArguments one = arguments;
        one.method = method;
        one.out = folder;
        one.notes = &notes;
        if (method != lcekf) one.constraints.clear();
        if (!recording) {
          recording = open_recording(arguments);
          frames = repeated_frames(*recording, arguments.frontend);
        }
        run_on(*recording, frames, one, &starts);
      });
}

}  // namespace

void add_run_command(CLI::App& app) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Navigate through a recording with one method, or several");
  add_recording_options(*command, *arguments);
  command
      ->add_option("--method", arguments->method,
                   "ekf, ekf-full, lcekf, soft, consider, adaptive, mono-left or oracle")
      ->check(parsed_by(method_from_string))
      ->capture_default_str();
  command
      ->add_option("--methods", arguments->methods,
                   "Several methods, as in ekf,lcekf,adaptive: each into OUT/METHOD, then a table and "
                   "OUT/comparison.html as limber compare makes them")
      ->delimiter(',')
      ->check(parsed_by(method_from_string))
      ->excludes("--method");
  command->add_option("--out", arguments->out, "Folder for the results")->required()->check(not_empty());
  command
      ->add_option(
          "--constraints", arguments->constraints,
          "lcekf: full, none, rotation, rotation+direction or a list of ax,ay,az,tx,ty,tz; other "
          "parameters (see --estimate) may follow: full,dt1; default: full where IMU or odometry fix "
          "the scale, else rotation+direction")
      ->check(parsed_by(constraint_set_from_string));
  add_start_draw_options(*command, arguments->seed, arguments->run);
  command->add_option("--landmarks", arguments->landmarks, "inverse-depth, or cartesian as in the paper")
      ->transform(one_of({"inverse-depth", "cartesian"}))
      ->capture_default_str();
  command->add_option("--gate", arguments->gate, "Refuse points whose projected residual is too large")
      ->transform(one_of({"on", "off"}))
      ->capture_default_str();
  command
      ->add_option("--max-landmarks", arguments->max_landmarks,
                   "Size of the map; those unseen for longest go")
      ->check(whole_number(1, 100'000))
      ->capture_default_str();
  command
      ->add_option("--points-per-update", arguments->points_per_update,
                   "Points of a frame that correct the state, spread over the image; the others wait until "
                   "one of them is lost, and tell of the calibration meanwhile. Default: 80 "
                   "where a recording has images, else 150")
      ->check(whole_number(1, 100'000));
  add_force_option(*command, arguments->force);
  add_view_options(*command, arguments->view);
  for (const char* const of_one_run : {"--view", "--view-out"}) {
    if (CLI::Option* option = command->get_option_no_throw(of_one_run)) {
      command->get_option("--methods")->excludes(option);
    }
  }
  command->footer(
      "\nCtrl-C ends the run early: what was done by then is written, marked as partial, and the exit code "
      "is "
      "1.\n"
      "Writes trajectory.tum, trajectory.csv, landmarks.ply, frames.csv, health.csv, refusals.csv,\n"
      "summary.json, report.html, and truth.tum (with velocity and biases: truth.csv) where the truth is "
      "known.\n"
      "Example:\n  limber run data/v101 --method lcekf --assume-error 0,0.5,0,5%,0,0 --out runs/v101\n"
      "  limber run data/v101 --methods ekf,lcekf,adaptive --out runs/v101-methods");
  command->callback([arguments] { arguments->methods.empty() ? run(*arguments) : run_each(*arguments); });
}

}  // namespace limber::app
