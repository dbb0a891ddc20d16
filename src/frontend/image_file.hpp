// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>

#include "limber/sensors/camera.hpp"

namespace limber::frontend {

/// "752 x 480 px"
[[nodiscard]] std::string size_text(int width, int height);

/// @brief Reads an image as it is stored: 8 or 16 bit, grey or colour.
/// @throws DataError if it cannot be read or decoded, or has not the camera's resolution
[[nodiscard]] cv::Mat read_unchanged(const std::filesystem::path& file, const Camera& camera);

/// @brief The content of an image file, of any format OpenCV knows, as 8 bit grey.
/// @param name  for messages
/// @throws DataError if it cannot be decoded, or has not this size
[[nodiscard]] cv::Mat grey_of_file(std::string_view bytes, int width, int height, const std::string& name);

/// @brief The same as grey, of 8 or 16 bit as it is stored.
[[nodiscard]] cv::Mat read_grey(const std::filesystem::path& file, const Camera& camera);

}  // namespace limber::frontend
