// SPDX-License-Identifier: MIT
#include "recording_options.hpp"

#include "limber/io/parameter_text.hpp"
#include "parsed_by.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

/// A rig to try on whether a text can be read at all; which one does not matter.
StereoCalibration some_rig() {
  StereoCalibration out;
  out.theta(3) = -1.0;
  return out;
}

}  // namespace

void add_start_option(CLI::App& command, std::string& start) {
  command.add_option("--init", start, "auto: from sensors; groundtruth: from the truth plus a drawn error")
      ->check(CLI::IsMember({name_of(StartMode::kAuto), name_of(StartMode::kGroundTruth)}))
      ->capture_default_str();
}

void add_recording_options(CLI::App& command, RecordingArguments& arguments) {
  command.add_option("DATASET", arguments.dataset, "Track log, EuRoC folder or KITTI odometry folder")
      ->required()
      ->check(not_empty());
  command
      .add_option(
          "--assume-error", arguments.assume_error,
          "ax,ay,az,tx,ty,tz added to the assumed calibration: degrees and metres, 5% is of the baseline; "
          "NAME=VALUE, instead or behind, for other parameters: dt1=0.005 [s], fu0=1%")
      ->check(parsed_by([](const std::string& text) { return parse_calibration_error(text, some_rig()); }));
  const auto sigmas =
      parsed_by([](const std::string& text) { return parse_parameter_sigmas(text, some_rig()); });
  command
      .add_option("--estimate", arguments.estimate,
                  "NAME[=SIGMA],...: parameters to estimate beside what the method does: ax ... tz, fu0 fv0 "
                  "cu0 cv0 radial0 dt0 of camera 0, the same of 1, imu-ax ... imu-tz, or groups theta, "
                  "intrinsics0, intrinsics1, imu")
      ->check(sigmas);
  command
      .add_option("--soften", arguments.soften,
                  "NAME[=SIGMA],...: parameters with an error that is fresh in every frame")
      ->check(sigmas);
  command
      .add_option("--sigma-px", arguments.sigma_px,
                  "Pixel noise [px]; default: the recording's, else 0.5 for images and 1 for tracks")
      ->check(positive());
  add_start_option(command, arguments.start);
  command
      .add_option("--clean", arguments.clean,
                  "End tracks and right matches that the front end has lost, as far as no jump of the rig "
                  "explains them")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  command
      .add_option("--max-points", arguments.max_points,
                  "Of a frame; those beyond are left out, evenly over the image")
      ->check(whole_number(10, 5000))
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
    options.assume_error = parse_calibration_error(arguments.assume_error, recording.calibration);
  }
  if (!arguments.estimate.empty()) {
    options.estimated = parse_parameter_sigmas(arguments.estimate, recording.calibration);
  }
  if (!arguments.soften.empty()) {
    options.softened = parse_parameter_sigmas(arguments.soften, recording.calibration);
  }
  options.sigma_px = arguments.sigma_px;
  options.cleaning = {arguments.clean == "on", arguments.max_points};
  options.start = start_mode_from_string(arguments.start);
  options.false_alarms_per_hour = arguments.false_alarms_per_hour;
  return options;
}

}  // namespace limber::app
