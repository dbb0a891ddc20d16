// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "limber/datasets/image_files.hpp"

namespace limber {

/// The bytes of a PNG or JPEG file that holds an image; `place` is for messages.
using ImageFileOf = std::function<std::vector<std::uint8_t>(const EncodedImage&, const std::string& place)>;

/// @brief Writes a recording with images as an EuRoC folder, `folder`/mav0/...: what read_recording reads
/// back. Image files go in byte by byte; `file_of` makes files of all others. Both images of a pair get its
/// time. IMU, odometry, stamps and ground truth keep every digit. Appears complete or not at all.
/// An image that cannot be read, or made a file of, is left out, the other of its pair is not.
/// @param replace   an older mav0 that this function, or write_track_log, has written is replaced
/// @param progress  told the pairs done; may be empty
/// @param stop      asked before every pair: true ends the work by std::runtime_error; may be empty
/// @return what was left out
/// @throws DataError if the folder cannot be written, its mav0 exists and must not be replaced, or the first
///         kFirstPairs images of a camera, or all, cannot be read
/// @throws std::invalid_argument if the recording has no images, times that do not increase, or the body
///         kMiddleOfBaseline
std::vector<LostImage> write_euroc(const Recording& recording, const std::filesystem::path& folder,
                                   const ImageFileOf& file_of, bool replace = false,
                                   const std::function<void(std::size_t)>& progress = {},
                                   const std::function<bool()>& stop = {});

}  // namespace limber
