// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "limber/decalibrate/bent_rig.hpp"

namespace limber {

/// How much of the right images the bent camera sees that the real one did not: black.
struct ImageBending {
  std::size_t images = 0;      ///< that were warped
  double black_mean = 0.0;     ///< share of the pixels of an image, mean
  double black_largest = 0.0;  ///< and largest
};

/// @brief Writes a recording with images (EuRoC or KITTI folder) as a rig that bends would have seen it.
/// Right images are warped by the homography of the rotation, raw pixel to raw pixel (distorted -> bearing ->
/// turned -> distorted), with Lanczos interpolation (8 x 8; positions rounded to 1/32 px); same size and bit
/// depth, as PNG. What the real camera did not see is black. Everything else is copied as it is: left images,
/// stamps, calibration, ground truth. Right images without a left one are left out. The true rig is added as
/// mav0/calibration_truth0/data.csv, or calibration_truth.csv (KITTI).
/// @param folder    is filled; should be a StagedFolder
/// @param progress  told the number of images done; may be empty
/// @param stop      asked before every image: true ends the work by std::runtime_error; may be empty
/// @throws DataError if an image cannot be read, or a file not be written
[[nodiscard]] ImageBending bend_images(const Recording& recording, const BentRig& rig,
                                       const std::filesystem::path& folder,
                                       const std::function<void(std::size_t)>& progress = {},
                                       const std::function<bool()>& stop = {});

}  // namespace limber
