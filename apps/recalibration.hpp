// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "frame_source.hpp"
#include "limber/run/recalibrate_recording.hpp"

namespace limber::app {

/// What limber recalibrate finds.
struct RecalibrationOutcome {
  Recalibration found;
  std::optional<BeforeAfter> ate;  ///< of ekf with either calibration, where there is a truth [m]
  std::vector<std::string> notes;  ///< found.notes and why an ATE is missing
};

/// Makes the frames of a recording; what these throw ends the work and passes through.
using FramesOf = std::function<ImageFrames(const Recording&)>;

/// @brief recalibrate_recording, and what ekf makes of either calibration.
/// @throws as recalibrate_recording
[[nodiscard]] RecalibrationOutcome recalibrate(const Recording& recording, const RecalibrateOptions& options,
                                               const FramesOf& frames,
                                               const std::function<void(std::size_t)>& progress);

/// @brief Nothing is replaced but what an earlier recalibration wrote, and nothing of `inputs`.
/// @throws as require_replaceable
void require_replaceable_recalibration(const std::filesystem::path& folder, bool force,
                                       const std::vector<std::filesystem::path>& inputs);

/// @brief Writes recalibration.json and, if `rig` is set, the corrected calibration in all formats that can
/// say it; files of the others' names, which require_replaceable_recalibration has let pass, are removed
/// then. Makes the folder.
void write_recalibration(const std::filesystem::path& folder, const RecalibrationOutcome& outcome,
                         const Recording& recording, bool rig);

}  // namespace limber::app
