// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "io/image_size.hpp"
#include "limber/core/errors.hpp"
#include "limber/images/picture.hpp"
#include "limber/sensors/camera.hpp"

namespace limber::frontend {

/// "752 x 480 px"
[[nodiscard]] std::string size_text(int width, int height);

/// For an image that has not the size of its camera [px].
[[nodiscard]] DataError other_size(const std::string& name, int width, int height,
                                   const detail::ImageSize& found);

/// @brief The content of an image file.
/// @param name  for messages
/// @throws DataError if it cannot be decoded, or has not this size
[[nodiscard]] Picture picture_of(std::string_view file, int width, int height, Colours colours,
                                 const std::string& name);

/// @brief Reads an image file.
/// @throws DataError if it cannot be read or decoded, or has not the camera's resolution
[[nodiscard]] Picture read_picture(const std::filesystem::path& file, const Camera& camera, Colours colours);

/// The largest number of a picture.
[[nodiscard]] unsigned largest_number(const Picture& picture);

/// The highest eight of the `bits` in use of a picture's numbers; of 8 bit, as they are.
[[nodiscard]] std::vector<std::uint8_t> highest_eight(Picture picture, int bits);

}  // namespace limber::frontend
