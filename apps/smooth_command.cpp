// SPDX-License-Identifier: MIT
// limber smooth: the whole recording as one least-squares problem.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "commands.hpp"
#include "frame_source.hpp"
#include "interrupt.hpp"
#include "limber/run/smooth_recording.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "parsed_by.hpp"
#include "progress.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "report_files.hpp"
#include "run_summary_text.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

struct SmoothArguments : RecordingArguments {
  std::filesystem::path out;
  std::string theta = "free", loss = "huber", guess = "auto";
  std::uint64_t seed = 0, run = 0;
  double window_s = 2.0;
  bool causal = false, force = false;
};

RobustLoss loss_from(const std::string& name) {
  return name == "none" ? RobustLoss::kNone : name == "cauchy" ? RobustLoss::kCauchy : RobustLoss::kHuber;
}

SmoothOptions to_options(const SmoothArguments& arguments, const Recording& recording) {
  SmoothOptions options;
  options.run = to_run_options(arguments, recording);
  options.run.seed = arguments.seed;
  options.run.run = arguments.run;
  const RigModelText theta = rig_model_from_string(arguments.theta);
  options.rig = theta.rig;
  options.piece_s = theta.piece_s;
  options.loss = loss_from(arguments.loss);
  if (arguments.causal) {
    options.causal_window_s = arguments.window_s;
  }
  if (arguments.guess != "auto") {
    options.guess = method_from_string(arguments.guess);
  }
  return options;
}

void smooth(const SmoothArguments& arguments) {
  require_replaceable_run(arguments.out, arguments.force);
  const ClaimedFolder claimed(arguments.out);
  const Interrupt interrupt;
  const Recording recording = open_recording(arguments);
  const SmoothOptions options = to_options(arguments, recording);
  const ImageFrames images = image_frames(recording, arguments.frontend);
  RunRecord record;
  {
    Progress progress("smooth", 100);
    record = smooth_recording(recording, options, stoppable(images.frames), [&](std::size_t percent) {
      Interrupt::check();
      progress.done(percent);
    });
  }
  add_damaged(images, record);
  RunSummary summary = summarize(recording, options.run, record);
  summary.method = to_string(options);
  write_run(arguments.out, arguments.force, options.run, record, summary);
  for (const std::string& note : record.notes) {
    print_note(note);
  }
  print_run_summary(options.run, record, summary, arguments.out);
  make_report_beside(arguments.out);
  if (!record.is_complete()) {
    throw CLI::RuntimeError(kExitFailed);  // the notes say why
  }
}

}  // namespace

void add_smooth_command(CLI::App& app) {
  auto arguments = std::make_shared<SmoothArguments>();
  CLI::App* command = app.add_subcommand(
      "smooth", "Least squares over a whole recording: every state from what all frames say");
  add_recording_options(*command, *arguments);
  // What a filter has and a batch has not.
  for (const char* name : {"--soften", "--false-alarms"}) {
    command->remove_option(command->get_option(name));
  }
  command->add_option("--out", arguments->out, "Folder for the results")->required()->check(not_empty());
  command
      ->add_option("--theta", arguments->theta,
                   "What the rig does: trusted, constant, piecewise:SECONDS, walk, or free in every frame")
      ->check(parsed_by(rig_model_from_string))
      ->capture_default_str();
  CLI::Option* causal =
      command->add_flag("--causal", arguments->causal,
                        "Each state from the frames up to it alone, as a filter has it: one problem a frame");
  command
      ->add_option("--window", arguments->window_s,
                   "With --causal: how long before a frame all is solved anew with it [s]")
      ->needs(causal)
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--loss", arguments->loss, "Of pixels: huber, cauchy or none (none refuses no pixel)")
      ->transform(one_of({"huber", "cauchy", "none"}))
      ->capture_default_str();
  command
      ->add_option(
          "--guess", arguments->guess,
          "Filter that gives the first guess; auto: ekf or lcekf, whichever explains the pixels better")
      ->check(parsed_by(
          [](const std::string& name) { return name == "auto" ? Method::kEkf : method_from_string(name); }))
      ->capture_default_str();
  add_start_draw_options(*command, arguments->seed, arguments->run);
  add_force_option(*command, arguments->force);
  command->footer(
      "\nWrites what limber run writes, without health.csv. Ctrl-C ends it: half a solution is none, nothing "
      "is written, and\n"
      "the exit code is 1.\n"
      "Example:\n  limber smooth data/v101 --theta constant --out runs/v101-smooth");
  command->callback([arguments] { smooth(*arguments); });
}

}  // namespace limber::app
