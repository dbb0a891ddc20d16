// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "limber/run/recalibrate_recording.hpp"

/// What limber recalibrate says, as text and as recalibration.json.
namespace limber::app {

inline constexpr int kExitUndecided = 4, kExitKept = 6;
inline constexpr const char* kRecalibrationFile = "recalibration.json";

/// @param ate      of ekf with either calibration [m]
/// @param written  folder of the new calibration; empty: none was written
[[nodiscard]] std::string to_text(const Recalibration& found, const std::string& dataset,
                                  const std::optional<BeforeAfter>& ate, const std::string& written);

/// @param files  that were written, relative to the folder
[[nodiscard]] std::string to_json(const Recalibration& found, const std::string& dataset,
                                  const std::optional<BeforeAfter>& ate,
                                  const std::vector<std::string>& files);

}  // namespace limber::app
