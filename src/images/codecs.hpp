// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "limber/images/picture.hpp"

/// One decoder a format. Each takes a file whose header is_...() has known, and throws std::runtime_error
/// with what it found instead of an image.
namespace limber::images {

[[nodiscard]] bool is_png(std::string_view file);
[[nodiscard]] Picture decode_png(std::string_view file);

[[nodiscard]] bool is_jpeg(std::string_view file);
[[nodiscard]] Picture decode_jpeg(std::string_view file, Colours colours);

[[nodiscard]] bool is_tiff(std::string_view file);
[[nodiscard]] Picture decode_tiff(std::string_view file);

[[nodiscard]] bool is_pnm(std::string_view file);
[[nodiscard]] Picture decode_pnm(std::string_view file);

}  // namespace limber::images
