// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <istream>
#include <optional>

namespace limber::detail {

struct ImageSize {
  int width = 0, height = 0;  ///< [px]
};

/// Size from the header of a PNG, JPEG, TIFF, PGM or PPM file. @throws DataError if it is missing or neither.
[[nodiscard]] ImageSize read_image_size(const std::filesystem::path& path);

/// The same of a file's content; nothing if it is neither.
[[nodiscard]] std::optional<ImageSize> image_size_of(std::istream& content);

}  // namespace limber::detail
