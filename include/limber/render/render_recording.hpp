// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>

#include "limber/render/picture_truth.hpp"

namespace limber {

/// @brief Writes what `simulate` makes as an EuRoC folder with images in place of matched points. The rig
/// bends between the images; where they are blurred or their shutter rolls, during the exposure too. Faults
/// of frames are those of the images; errors of pixels beyond the images' own noise are not for them.
/// @param folder    is filled with mav0; should be a StagedFolder
/// @param progress  told the number of pairs done; may be empty
/// @param stop      asked before every pair: true ends the work by std::runtime_error; may be empty
/// @return number of pairs
/// @throws as PictureTruth and write_track_log
std::size_t render_recording(const Scenario& scenario, std::uint64_t seed, std::uint64_t run,
                             const PictureOptions& options, const std::filesystem::path& folder,
                             const std::function<void(std::size_t)>& progress = {},
                             const std::function<bool()>& stop = {});

}  // namespace limber
