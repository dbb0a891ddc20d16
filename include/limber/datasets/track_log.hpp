// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "limber/datasets/recording.hpp"

namespace limber {

/// @brief Writes a recording with matched points as a track log, `folder`/mav0/...: what read_recording reads
/// back. Numbers come back exactly as they were; rotations and theta up to rounding (1e-15), because the
/// format stores quaternions and one T_BS per camera. Names, notes and images are not part of a track log.
/// Appears complete or not at all. `folder` is made if needed.
/// @param replace  an older track log by limber in `folder` is replaced as a whole
/// @throws std::invalid_argument if the recording has no frames, times that do not increase, numbers that are
/// not
///         finite, or the body kMiddleOfBaseline, which the format cannot say
/// @throws DataError if the folder cannot be written, or its mav0 exists and must not be replaced
void write_track_log(const Recording& recording, const std::filesystem::path& folder, bool replace = false);

/// @brief The true rig over time as the text of calibration_truth0/data.csv, or of a KITTI folder's
/// calibration_truth.csv.
/// @throws std::invalid_argument for times that do not increase, or numbers that are not finite
[[nodiscard]] std::string calibration_truth_text(const std::vector<TrueRig>& truth);

}  // namespace limber
