// SPDX-License-Identifier: MIT
// limber evaluate: a trajectory against the truth.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "evaluation_report.hpp"
#include "limber/io/atomic_file.hpp"
#include "messages.hpp"
#include "ordered_json.hpp"
#include "replaceable.hpp"
#include "trajectory_input.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

struct EvaluateOptions {
  std::filesystem::path estimate, truth, out;
  std::string estimate_topic, truth_topic;
  double max_time_difference = kMaxTimeDifference;
  RelativeErrorSettings settings;
  bool json = false, force = false;
};

void evaluate(const EvaluateOptions& options) {
  if (!options.out.empty()) {
    require_replaceable(options.out, kEvaluationMark, options.force, {options.estimate, options.truth});
  }
  const TrajectoryInput estimate = load_trajectory(options.estimate, options.estimate_topic);
  const TrajectoryInput truth = load_truth(options.truth, options.truth_topic);
  for (const TrajectoryInput* input : {&estimate, &truth}) {
    if (!input->topic.empty()) {
      print_note(input->path.string() + ": poses of " + input->topic);
    }
  }
  const EvaluationReport report =
      limber::app::evaluate(estimate, truth, options.max_time_difference, options.settings);
  const std::string json = json_text(to_json(report));
  if (!options.out.empty()) {
    write_file_atomically(options.out, json);
  }
  fmt::print("{}", options.json ? json : to_text(report));
}

}  // namespace

void add_evaluate_command(CLI::App& app) {
  auto options = std::make_shared<EvaluateOptions>();
  CLI::App* command =
      app.add_subcommand("evaluate", "Compare a trajectory with the truth: ATE, RPE, attitude, NEES");
  command
      ->add_option("ESTIMATE", options->estimate,
                   "Trajectory file, folder of a run (its trajectory.csv), or a bag with poses")
      ->required()
      ->check(not_empty());
  command
      ->add_option("GROUNDTRUTH", options->truth,
                   "Trajectory file, folder of a recording, or a bag with poses")
      ->required()
      ->check(not_empty());
  command->add_option(
      "--estimate-topic", options->estimate_topic,
      "Of ESTIMATE, where it is a bag; default: that of limber's run, else the only one with poses");
  command->add_option("--truth-topic", options->truth_topic,
                      "Of GROUNDTRUTH, where it is a bag; default: the one that is named like a truth");
  command
      ->add_option("--max-time-difference", options->max_time_difference,
                   "How far ground truth may be from a pose [s]")
      ->check(not_negative())
      ->capture_default_str();
  command->add_option("--rpe-distance", options->settings.distance, "Distance of the relative error [m]")
      ->check(positive())
      ->capture_default_str();
  command->add_flag("--json", options->json, "Print JSON instead of tables");
  command->add_option("--out", options->out, "Write the JSON to this file too")->check(not_empty());
  add_force_option(*command, options->force);
  command->footer(
      "\nTrajectory files: TUM (t x y z qx qy qz qw), KITTI poses (12 numbers), EuRoC ground truth, "
      "limber's\n"
      "trajectory.csv; the content tells which. In bags (ROS 1, MCAP, ROS 2): PoseStamped, "
      "TransformStamped,\n"
      "Odometry. Poses are matched in time, with the ground truth "
      "interpolated, or\n"
      "line by line if a file has no times (KITTI). Absolute and relative errors are those of the tool evo: "
      "the\n"
      "alignments are fitted over all poses, the scale multiplies the estimate, the relative error over a "
      "distance\n"
      "takes all pairs that far apart along the estimated path (within 10 %). 'first pose' aligns position "
      "and yaw\n"
      "of the first pose only; 'upright', where the vertical of one world is off throughout, takes that tilt "
      "out\n"
      "before. NEES needs a trajectory.csv with covariance; frames later than 1 s enter.\n"
      "Example:\n"
      "  limber evaluate runs/v101 data/v101 --out evaluation.json");
  command->callback([options] { evaluate(*options); });
}

}  // namespace limber::app
