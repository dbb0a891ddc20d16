// SPDX-License-Identifier: MIT
#include "limber/run/run_options.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "limber/core/nearest_word.hpp"

namespace limber {
namespace {

constexpr double kSmallestBaseline = 1e-4;  // [m]
constexpr double kLargestError = 10.0;      // of an assumed calibration, in baselines
constexpr double kLargestTimeOffset = 0.1;  // [s]
constexpr double kSmallestSigmaPx = 1e-6, kLargestSigmaPx = 1e3;
// Pixel noise where the recording says nothing: limber's own front end, and somebody's tracks.
constexpr double kImageSigmaPx = 0.5;
constexpr double kTrackSigmaPx = 1.0;
constexpr double kOdometryScale = 0.01;  // [-]: what the size of a wheel is known to
/// Errors of the front end's points last as long as their tracks, so that more of them say hardly more
/// (docs/evidence/peers.md).
constexpr std::size_t kImagePointsPerUpdate = 80;
/// Of somebody's tracks. A frame's time grows with the square of its points, and more, and errors hardly fall
/// (docs/evidence/benchmarks.md).
constexpr std::size_t kTrackPointsPerUpdate = 150;

MotionModel choose_motion(const SensorData& sensors, RunSetup& setup) {
  if (!sensors.imu.empty()) {
    if (!sensors.odometry.empty()) {
      setup.notes.emplace_back("the IMU drives the prediction: odometry beside it is not used");
    }
    return MotionModel::kImu;
  }
  if (!sensors.odometry.empty()) {
    return MotionModel::kOdometry;
  }
  setup.notes.emplace_back("neither IMU nor odometry: constant-velocity model");
  return MotionModel::kConstantVelocity;
}

ConstraintSet choose_constraints(const RunOptions& options, MotionModel motion, RunSetup& setup) {
  if (options.constraints) {
    return *options.constraints;
  }
  if (has_scale(motion)) {
    setup.notes.push_back(fmt::format("constraints full: the scale comes from the {}",
                                      motion == MotionModel::kImu ? "IMU" : "odometry"));
  } else {
    setup.notes.emplace_back(
        "constraints rotation+direction: nothing but the baseline's length fixes the scale, so it is "
        "trusted");
  }
  return default_constraints(motion);
}

template <typename T>
void take(const std::optional<T>& given, T& value, const std::string& note, RunSetup& setup) {
  if (given) {
    value = *given;
  } else {
    setup.notes.push_back(note);
  }
}

void choose_noise(const SensorData& sensors, const RunOptions& options, RunSetup& setup) {
  NavigatorOptions& navigator = setup.navigator;
  if (navigator.motion == MotionModel::kImu) {
    take(sensors.imu_noise, navigator.imu_noise, "IMU noise not given: that of a small MEMS IMU (ADIS16448)",
         setup);
  }
  if (navigator.motion == MotionModel::kOdometry) {
    navigator.learn_odometry_noise = !sensors.odometry_noise;
    navigator.doubt_odometry_mount = options.doubt_odometry_mount.value_or(!sensors.odometry_noise);
    navigator.odometry_scale = options.odometry_scale.value_or(sensors.odometry_noise ? 0.0 : kOdometryScale);
    take(
        sensors.odometry_noise, navigator.odometry_noise,
        fmt::format("odometry noise not given: learned, from {} m/s and {} rad/s per sample on{}; its speeds "
                    "may be {:.3g} % long or short all the time, and so may all lengths (--odometry-scale)",
                    navigator.odometry_noise.sigma_v.x(), navigator.odometry_noise.sigma_omega.x(),
                    navigator.doubt_odometry_mount ? "; its mount may be off by 0.5 deg" : "",
                    100.0 * navigator.odometry_scale),
        setup);
  }
  // A recording that states the noise of its pixels is a simulated one: from the truth on, its filter is the
  // paper's.
  navigator.carries_scale = options.start != StartMode::kGroundTruth || !sensors.pixel_noise;
  navigator.learn_imu_noise = options.learn_imu_noise && navigator.carries_scale;
  navigator.learn_imu_clock = options.learn_imu_clock && options.start == StartMode::kAuto;
  if (options.sigma_px) {
    navigator.sigma_px.setConstant(*options.sigma_px);
  } else {
    const double sigma = sensors.images.empty() ? kTrackSigmaPx : kImageSigmaPx;
    navigator.sigma_px.setConstant(sigma);
    navigator.learn_pixel_noise = !sensors.pixel_noise;
    take(sensors.pixel_noise, navigator.sigma_px,
         fmt::format("pixel noise not given: learned, from {} px on", sigma), setup);
  }
  if (navigator.sigma_px.minCoeff() < kSmallestSigmaPx || navigator.sigma_px.maxCoeff() > kLargestSigmaPx) {
    throw std::invalid_argument(fmt::format("pixel noise: expected {} to {} px, found {} to {} px",
                                            kSmallestSigmaPx, kLargestSigmaPx, navigator.sigma_px.minCoeff(),
                                            navigator.sigma_px.maxCoeff()));
  }
}

/// The error that is added must leave something that can still be called this rig.
void check_assumed(const StereoCalibration& given, const StereoCalibration& assumed) {
  const Eigen::Vector3d t = given.theta.tail<3>(), t_assumed = assumed.theta.tail<3>();
  if (!(assumed.baseline() > kSmallestBaseline) || t.dot(t_assumed) <= 0.0) {
    throw std::invalid_argument(fmt::format(
        "--assume-error: expected an error that leaves cam1 on its side of cam0, found one that turns the "
        "baseline [{:.4g}, {:.4g}, {:.4g}] m into [{:.4g}, {:.4g}, {:.4g}] m",
        t.x(), t.y(), t.z(), t_assumed.x(), t_assumed.y(), t_assumed.z()));
  }
  if ((t_assumed - t).norm() > kLargestError * given.baseline()) {
    throw std::invalid_argument(
        fmt::format("--assume-error: expected at most {} baselines of {:.4g} m, found {:.4g} m",
                    kLargestError, given.baseline(), (t_assumed - t).norm()));
  }
  for (const Camera& camera : {assumed.cam0, assumed.cam1}) {
    if (!(camera.fu > 0.0 && camera.fv > 0.0)) {
      throw std::invalid_argument(fmt::format(
          "--assume-error: expected an error that leaves focal lengths positive, found {:.4g} and {:.4g} px",
          camera.fu, camera.fv));
    }
  }
  for (const double offset : assumed.time_offset_s) {
    if (std::abs(offset) > kLargestTimeOffset) {
      throw std::invalid_argument(
          fmt::format("--assume-error: expected time offsets within ±{} s, found {} s; images that far from "
                      "their stamps are none of this pose",
                      kLargestTimeOffset, offset));
    }
  }
}

void check(const Recording& recording, const RunOptions& options) {
  if (options.start == StartMode::kGroundTruth && recording.truth.motion.states.empty()) {
    throw std::invalid_argument("--init groundtruth: " + recording.name +
                                " has no ground truth; use --init auto");
  }
  if (options.method == Method::kOracle && recording.truth.rig.empty()) {
    throw std::invalid_argument(
        "oracle: " + recording.name +
        " does not say what the true calibration is (mav0/calibration_truth0); only simulated "
        "recordings do");
  }
}

}  // namespace

std::string_view name_of(StartMode start) {
  return start == StartMode::kGroundTruth ? "groundtruth" : "auto";
}

StartMode start_mode_from_string(std::string_view text) {
  const std::string word = in_lower_case(std::string(text));
  for (const StartMode start : {StartMode::kAuto, StartMode::kGroundTruth}) {
    if (word == name_of(start)) {
      return start;
    }
  }
  throw std::invalid_argument(fmt::format("expected a start 'auto' or 'groundtruth', found '{}'", text));
}

WatchOptions watch_options(const RunOptions& options) {
  WatchOptions out;
  out.tolerance = options.tolerance;
  out.false_alarms_per_hour = options.false_alarms_per_hour;
  return out;
}

RunSetup set_up_run(const Recording& recording, const RunOptions& options) {
  check(recording, options);
  RunSetup setup;
  setup.notes = recording.notes;
  setup.calibration = corrected(recording.calibration, options.assume_error);
  check_assumed(recording.calibration, setup.calibration);
  NavigatorOptions& navigator = setup.navigator;
  navigator.method = options.method;
  navigator.motion = choose_motion(recording, setup);
  if (options.method == Method::kLcekf) {
    navigator.constraints = choose_constraints(options, navigator.motion, setup);
  }
  choose_noise(recording, options, setup);
  navigator.gravity = options.gravity;
  navigator.constant_velocity_noise =
      options.constant_velocity_noise.value_or(navigator.constant_velocity_noise);
  navigator.learn_motion_noise = !options.constant_velocity_noise && navigator.carries_scale;
  navigator.theta_sigma = options.theta_sigma.value_or(plausible_error(setup.calibration.baseline()));
  navigator.estimated = options.estimated;
  navigator.softened = options.softened;
  navigator.theta_walk = options.theta_walk.value_or(default_theta_walk(setup.calibration.baseline()));
  navigator.landmarks = options.landmarks;
  navigator.gate = options.gate;
  if (options.watch) {
    navigator.health->false_alarms_per_hour = options.false_alarms_per_hour;
    navigator.verdict = watch_options(options);
  } else {
    navigator.health.reset();
  }
  navigator.map.max_landmarks = options.max_landmarks;
  navigator.map.points_per_update = recording.images.empty() ? kTrackPointsPerUpdate : kImagePointsPerUpdate;
  if (!recording.images.empty()) {
    navigator.map.forget_after_s = 0.0;  // a track that the front end has lost never comes back
  }
  if (options.points_per_update) {
    navigator.map.points_per_update = *options.points_per_update;
  }
  return setup;
}

}  // namespace limber
