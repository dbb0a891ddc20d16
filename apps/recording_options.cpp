// SPDX-License-Identifier: MIT
#include "recording_options.hpp"

#include "parsed_by.hpp"
#include "validators.hpp"

namespace limber::app {

void add_recording_options(CLI::App& command, RecordingArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "Track log, EuRoC folder or KITTI odometry folder")
      ->required()
      ->check(not_empty());
  command
      .add_option(
          "--assume-error", arguments.assume_error,
          "ax,ay,az,tx,ty,tz added to the assumed calibration: degrees and metres, 5% is of the baseline")
      ->check(parsed_by([](const std::string& text) { return parse_rig_error(text, 1.0); }));
  command
      .add_option("--sigma-px", arguments.sigma_px,
                  "Pixel noise [px]; default: the recording's, else 0.5 for images and 1 for tracks")
      ->check(positive());
  command
      .add_option("--init", arguments.start,
                  "auto: from sensors; groundtruth: from the truth plus a drawn error")
      ->check(CLI::IsMember({"auto", "groundtruth"}))
      ->capture_default_str();
  command
      .add_option("--false-alarms", arguments.false_alarms_per_hour,
                  "Of the calibration monitor, per hour of a sound rig")
      ->check(positive())
      ->capture_default_str();
}

RunOptions to_run_options(const RecordingArguments& arguments, const Recording& recording) {
  RunOptions options;
  if (!arguments.assume_error.empty()) {
    options.assume_error = parse_rig_error(arguments.assume_error, recording.calibration.baseline());
  }
  options.sigma_px = arguments.sigma_px;
  options.start = arguments.start == "groundtruth" ? StartMode::kGroundTruth : StartMode::kAuto;
  options.false_alarms_per_hour = arguments.false_alarms_per_hour;
  return options;
}

}  // namespace limber::app
