// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "io/image_size.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/recording.hpp"

/// What may be wrong with single image files of a folder, and what with all of them.
namespace limber::detail {

/// Whether there is a file, or a link to one: no folder, no pipe.
[[nodiscard]] bool is_image_file(const std::filesystem::path& path);

/// @brief A pair without its files costs its frame when it is asked for, as a damaged one does.
/// @param missing  an error for each pair of the recording that lacks a file
/// @throws DataError the first one, where more than half of the pairs do
void require_most_images(const Recording& recording, const std::vector<DataError>& missing);

/// An image, and the size that most have.
struct UsualImage {
  /// the first one of this size
  std::filesystem::path file;
  ImageSize size;  ///< [px]
};

/// @brief The size of most of nine images of one camera, evenly over the recording; of equally many that of
/// the earlier ones. Reads heads alone.
/// @param camera  0 or 1
/// @throws DataError for the first of them if none can be read
[[nodiscard]] UsualImage usual_image(const Recording& recording, std::size_t camera);

}  // namespace limber::detail
