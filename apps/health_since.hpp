// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "diagnosis.hpp"
#include "limber/sensors/calibration.hpp"

/// `--since`: an earlier recording of the same rig.
namespace limber::app {

/// @brief What an earlier recording said of its rig.
/// @throws DataError as read_health_state, and if it is of other cameras than these
[[nodiscard]] HealthState earlier_state(const std::filesystem::path& since, const StereoCalibration& assumed);

/// @param file  for messages
/// @throws DataError if the state is of other cameras than these
void require_same_cameras(const HealthState& state, const StereoCalibration& assumed,
                          const std::string& file);

/// What moved; nothing if one of the two says nothing of its rig.
[[nodiscard]] std::optional<SinceThen> since_then(const std::optional<HealthState>& before,
                                                  const Diagnosis& now);

}  // namespace limber::app
