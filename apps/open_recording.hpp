// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "limber/datasets/recording.hpp"

namespace limber::app {

/// Which recording, and what stands in the place of what it says of itself; empty: nothing. The names are
/// those of the options of `limber run`.
struct RecordingFiles {
  std::filesystem::path dataset, calibration, imu;
  std::string images, topics;
  std::optional<double> readout_time;  ///< of both cameras [s]
  std::string for_images;  ///< an option that was given and says something to recordings with images alone
};

/// The recording, a bag or a folder, with the calibration of --calib and the noise of --imu in the place of
/// its own.
/// @throws as limber::read_recording, read_rig_file and read_kalibr_imu; DataError also if calibration and
/// recording do not belong together; CLI::ValidationError where an option is missing or of no use
[[nodiscard]] Recording open_recording(const RecordingFiles& files);

}  // namespace limber::app
