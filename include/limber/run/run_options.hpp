// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "limber/clean/frame_cleaner.hpp"
#include "limber/datasets/recording.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/state/initial_state.hpp"

namespace limber {

/// Where a run starts from.
enum class StartMode : std::uint8_t {
  kAuto,        ///< sensors alone
  kGroundTruth  ///< the truth plus an error drawn from the initial sigmas; for experiments
};

/// "auto" and "groundtruth", as --init takes them.
[[nodiscard]] std::string_view name_of(StartMode start);
/// @throws std::invalid_argument for another word
[[nodiscard]] StartMode start_mode_from_string(std::string_view text);

/// What a user chooses for a run; everything else follows from the recording.
struct RunOptions {
  /// what the filter makes of theta
  Method method = Method::kLcekf;
  std::optional<ConstraintSet> constraints;  ///< lcekf; nothing: the default for the recording's sensors
  ParameterVector assume_error = ParameterVector::Zero();  ///< added to the assumed calibration
  ParameterVector estimated = ParameterVector::Zero();     ///< see NavigatorOptions
  ParameterVector softened = ParameterVector::Zero();      ///< see NavigatorOptions
  std::optional<bool> doubt_odometry_mount;                ///< nothing: where nobody stated odometry's noise
  /// See NavigatorOptions [-]; nothing: 1 % where nobody stated odometry's noise, else none.
  std::optional<double> odometry_scale;
  /// IMU: what was stated is the least noise, and how much more there is is learned; not where pixels are
  /// white by the recording and the start is the truth's, as in the paper.
  bool learn_imu_noise = true;
  /// IMU: see NavigatorOptions. Only with a start from the sensors.
  bool learn_imu_clock = true;
  std::optional<double> sigma_px;  ///< nothing: the recording's, or the default
  /// sensors or truth
  StartMode start = StartMode::kAuto;
  InitialSigma initial;  ///< kGroundTruth: what the estimator assumes of its start
  std::optional<InitialSigma>
      initial_error;  ///< kGroundTruth: what the start error is drawn from; nothing: `initial`
  /// how points stand in the state
  LandmarkKind landmarks = LandmarkKind::kInverseDepth;
  /// refuse points whose projected residual is too large
  bool gate = true;
  /// of the map; those unseen for longest go
  std::size_t max_landmarks = 300;
  std::optional<std::size_t> points_per_update;  ///< nothing: 80 of images, else 150
  CleaningOptions cleaning;                      ///< of every frame, before the navigator sees it
  std::optional<RigParameters>
      theta_sigma;  ///< ekf-full, soft, consider; nothing: 0.1 deg and 5 % of the baseline
  std::optional<RigParameters>
      theta_walk;  ///< ekf-full, variance per second; nothing: Table 1, see run_setup
  std::optional<ConstantVelocityNoise> constant_velocity_noise;          ///< nothing: the navigator's default
  double gravity = 9.81;                                                 ///< [m/s^2]
  double false_alarms_per_hour = HealthOptions{}.false_alarms_per_hour;  ///< of the health monitor; > 0
  Tolerance tolerance{};                                                 ///< of the calibration's verdict
  /// of the start error
  std::uint64_t seed = 0;
  std::uint64_t run = 0;        ///< which draw of the start error
  bool stop_when_lost = false;  ///< a filter that broke down ends the run (studies) instead of beginning anew
  int threads = 1;    ///< more than one: the start is smoothed while the filter works; the same bits
  bool watch = true;  ///< false: no health monitor, for studies that do not ask for it
};

/// How the calibration of a run is judged.
[[nodiscard]] WatchOptions watch_options(const RunOptions& options);

/// A navigator's options for a recording, and every choice that was made on the user's behalf, in plain
/// words.
struct RunSetup {
  /// as the recording and the user have it
  NavigatorOptions navigator;
  StereoCalibration calibration;  ///< with assume_error
  /// choices made on the user's behalf
  std::vector<std::string> notes;
};

/// @brief Chooses motion model, noise and constraint set for a recording.
/// IMU before odometry before constant velocity. Constraints of lcekf: `full` where IMU or odometry fix the
/// scale, else `rotation+direction`. theta_walk defaults to the paper's 1e-6 rad² and 1 mm² per 10 ms, the
/// translation in proportion to the baseline (the paper's is 2 m). Of images, an update takes 80 points of a
/// frame.
/// @throws std::invalid_argument for ground truth start or oracle without the truth they need, or a baseline
/// that
///         assume_error makes vanish
[[nodiscard]] RunSetup set_up_run(const Recording& recording, const RunOptions& options);

}  // namespace limber
