// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace limber::detail {

struct ImageSize {
  int width = 0, height = 0;  ///< [px]
};

/// Size from the header of a PNG or JPEG file. @throws DataError if it is missing or neither.
[[nodiscard]] ImageSize read_image_size(const std::filesystem::path& path);

}  // namespace limber::detail
