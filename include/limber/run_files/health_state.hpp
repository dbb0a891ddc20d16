// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "limber/health/calibration_change.hpp"
#include "limber/sensors/calibration.hpp"

/// @file
/// health_state.json: what `limber health` keeps for `--since`. Format: docs/formats-health.md.
namespace limber {

inline constexpr std::string_view kHealthStateName = "health_state.json";  ///< in the folder of a run

/// A rig's state with the recording and the cameras that it is of.
struct HealthState {
  /// its name
  std::string recording;
  std::array<std::string, 2> cameras;  ///< in words, see camera_in_words
  /// estimate at the end of the recording
  RigRecord rig;
};

/// Size, intrinsics and distortion, so that equal cameras have equal words.
[[nodiscard]] std::string camera_in_words(const Camera& camera);

/// The text of health_state.json.
[[nodiscard]] std::string to_json(const HealthState& state);

/// @param name  for messages
/// @throws DataError if it is none, with what was expected
[[nodiscard]] HealthState parse_health_state(const std::string& text, const std::string& name);

/// @throws DataError if the file cannot be written
void write_health_state(const std::filesystem::path& path, const HealthState& state);

/// The file itself, also where its folder is given.
[[nodiscard]] std::filesystem::path health_state_file(const std::filesystem::path& path);

/// @param path  the file, or a folder with one
/// @throws as parse_health_state, and if it cannot be read
[[nodiscard]] HealthState read_health_state(const std::filesystem::path& path);

}  // namespace limber
