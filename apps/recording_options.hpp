// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "frame_source.hpp"
#include "limber/run/run_options.hpp"
#include "open_recording.hpp"

/// What `limber run` and `limber health` ask alike: which recording, and what to assume of it.
namespace limber::app {

struct RecordingArguments : RecordingFiles {
  std::string assume_error, estimate, soften, start = "auto", clean = "on", tolerance;
  std::size_t max_points = CleaningOptions{}.max_points;
  FrontendArguments frontend;
  std::optional<double> sigma_px;
  std::string imu_noise = "learned", imu_clock = "learned";
  std::optional<double> odometry_scale;
  double false_alarms_per_hour = RunOptions{}.false_alarms_per_hour;
};

/// --init.
void add_start_option(CLI::App& command, std::string& start);

/// --seed and --run.
void add_start_draw_options(CLI::App& command, std::uint64_t& seed, std::uint64_t& run);

/// Which recording, and its calibration.
void add_input_options(CLI::App& command, RecordingArguments& arguments);

/// These, and what to assume.
void add_recording_options(CLI::App& command, RecordingArguments& arguments);

/// Run options with these, everything else as by default.
/// @throws std::invalid_argument as parse_calibration_error and parse_parameter_sigmas
[[nodiscard]] RunOptions to_run_options(const RecordingArguments& arguments, const Recording& recording);

}  // namespace limber::app
