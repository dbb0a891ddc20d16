// SPDX-License-Identifier: MIT
#include "recording_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "limber/bags/read_bag.hpp"
#include "limber/io/parameter_text.hpp"
#include "limber/run/parse_tolerance.hpp"
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
      ->transform(
          one_of({std::string(name_of(StartMode::kAuto)), std::string(name_of(StartMode::kGroundTruth))}))
      ->capture_default_str();
}

void add_start_draw_options(CLI::App& command, std::uint64_t& seed, std::uint64_t& run) {
  command.add_option("--seed", seed, "Of the start error with --init groundtruth")
      ->check(whole_number())
      ->capture_default_str();
  command.add_option("--run", run, "Which draw of the start error, as in limber simulate")
      ->check(whole_number())
      ->capture_default_str();
}

void add_input_options(CLI::App& command, RecordingArguments& arguments) {
  command
      .add_option("DATASET", arguments.dataset,
                  "Track log, EuRoC or KITTI folder; ROS 1 bag, MCAP or ROS 2 bag (with --calib)")
      ->required()
      ->check(not_empty());
  CLI::Option* calibration =
      command
          .add_option(
              "--calib", arguments.calibration,
              "Calibration in the place of the recording's own: Kalibr camchain, OpenCV stereo YAML, Basalt "
              "JSON, KITTI calib.txt or calib_cam_to_cam.txt, folder with cam0/sensor.yaml")
          ->check(not_empty());
  command
      .add_option("--imu", arguments.imu,
                  "Kalibr imu.yaml: noise of the IMU in the place of the recording's own")
      ->check(not_empty());
  command
      .add_option(
          "--readout-time", arguments.readout_time,
          "How long an image takes from its first row to its last [s], in the place of what the "
          "calibration says: rolling shutter, the middle row exposed at the stamp; negative: last row first")
      ->check(number_that(fmt::format("a number from -{0} to {0}", kLongestReadout),
                          [](double x) { return std::abs(x) <= kLongestReadout; }));
  command
      .add_option(
          "--images", arguments.images,
          "What the images are, where --calib holds both or the recording's own calibration says otherwise")
      ->transform(one_of({"raw", "rectified"}))
      ->needs(calibration);
  command
      .add_option(
          "--topics", arguments.topics,
          "Of a bag: left=TOPIC,right=TOPIC,imu=TOPIC,odometry=TOPIC,truth=TOPIC; default: what limber "
          "info proposes")
      ->check(parsed_by(parse_bag_topics));
}

void add_recording_options(CLI::App& command, RecordingArguments& arguments) {
  add_input_options(command, arguments);
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
                  "Pixel noise [px], white; default: the recording's, else learned")
      ->check(positive());
  const auto learned_or_stated = [&command](const char* name, std::string& chosen, const char* words) {
    command.add_option(name, chosen, words)->transform(one_of({"learned", "stated"}))->capture_default_str();
  };
  learned_or_stated("--imu-noise", arguments.imu_noise,
                    "stated: the recording's alone; learned: as much more as images ask for");
  learned_or_stated(
      "--imu-clock", arguments.imu_clock,
      "stated: samples were taken when they are stamped; learned: a start from the sensors asks "
      "the images how much earlier or later");
  command
      .add_option(
          "--odometry-scale", arguments.odometry_scale,
          "By what share odometry's speeds may be long or short all the time, 1σ: 0.02 is 2 %; default: "
          "0.01 where its noise is not stated, else 0")
      ->check(number_that("a number from 0 to 0.5", [](double x) { return x >= 0.0 && x <= 0.5; }));
  add_start_option(command, arguments.start);
  command
      .add_option("--clean", arguments.clean,
                  "End tracks and right matches that the front end has lost, as far as no jump of the rig "
                  "explains them, and points that go with the camera")
      ->transform(one_of({"on", "off"}))
      ->capture_default_str();
  command
      .add_option("--max-points", arguments.max_points,
                  "Of a frame; those beyond are left out, evenly over the image")
      ->check(whole_number(10, 5000))
      ->capture_default_str();
  command.add_option("--max-tracks", arguments.frontend.max_tracks, "Images: points followed at a time")
      ->check(whole_number(10, 2000))
      ->each([&arguments](const std::string&) { arguments.for_images = "--max-tracks"; })
      ->capture_default_str();
  command
      .add_option(
          "--threads", arguments.frontend.threads,
          "Images: 3 decodes, tracks and filters at the same time, 2 decodes and tracks while the filter "
          "works, 1 in turn; the result is the same")
      ->check(whole_number(1, 3))
      ->each([&arguments](const std::string&) { arguments.for_images = "--threads"; })
      ->capture_default_str();
  command
      .add_option("--false-alarms", arguments.false_alarms_per_hour,
                  "Changes of the calibration seen in a rig that does not change, per hour")
      ->check(positive())
      ->capture_default_str();
  command
      .add_option(
          "--tolerance", arguments.tolerance,
          "NAME=OK[:WRONG],...: how wrong the calibration may be, by effect (px, depth in % at so many "
          "baselines) or by axis (ax, ay, az in deg, tx, ty, tz in mm); default "
          "px=0.3:1,depth=5:10,baselines=90")
      ->check(parsed_by([](const std::string& text) { (void)parse_tolerance(text); }));
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
  options.learn_imu_noise = arguments.imu_noise == "learned";
  options.learn_imu_clock = arguments.imu_clock == "learned";
  options.odometry_scale = arguments.odometry_scale;
  options.cleaning.clean = options.cleaning.still_points = arguments.clean == "on";
  options.threads = arguments.frontend.threads;
  options.cleaning.max_points = arguments.max_points;
  options.start = start_mode_from_string(arguments.start);
  if (!arguments.tolerance.empty()) {
    options.tolerance = parse_tolerance(arguments.tolerance);
  }
  options.false_alarms_per_hour = arguments.false_alarms_per_hour;
  return options;
}

}  // namespace limber::app
