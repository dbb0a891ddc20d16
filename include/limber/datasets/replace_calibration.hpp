// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "limber/datasets/recording.hpp"
#include "limber/rig_files/rig_file.hpp"

namespace limber {

/// Which images a recording holds, by its own calibration: rectified ones have no distortion.
[[nodiscard]] ImageKind image_kind(const StereoCalibration& calibration);

/// Who says which images there are.
enum class WhoSays : std::uint8_t { kUser, kRecording /*!< by its own calibration */ };

/// @brief What must hold of a calibration for images of this kind.
/// @throws std::invalid_argument if it is of the other one
void require_calibration_of(const RigFile& rig, ImageKind images, WhoSays who);

/// @brief Puts another calibration in the place of the recording's own. What the file does not say (size of
/// the images, place on the IMU, noise) stays; `notes` says what was taken. A body that is the left camera
/// stays so.
/// @param images  what the user says of the images; nothing: what the recording's own calibration says of
/// them
/// @throws std::invalid_argument if the file is of other images (raw, rectified) or of another size
void replace_calibration(Recording& recording, const RigFile& rig, std::optional<ImageKind> images);

}  // namespace limber
