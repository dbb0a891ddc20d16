// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>

#include "limber/images/picture.hpp"

namespace limber::images {

/// @brief What cameras write: grey or RGB of 8 or 16 bits, row after row. In half of libpng's time: inflated
/// by libdeflate, and the rows' filters are undone in one pass, which libpng does byte by byte for grey.
/// @return nothing of any other PNG, and of one that is damaged in whatever way: libpng says what it is
/// @throws std::runtime_error as blank()
[[nodiscard]] std::optional<Picture> decode_plain_png(std::string_view file);

}  // namespace limber::images
