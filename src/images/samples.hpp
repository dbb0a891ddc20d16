// SPDX-License-Identifier: MIT
#pragma once

#include "limber/images/picture.hpp"

namespace limber::images {

/// Zeros, of this size. @throws std::runtime_error for more than 2^28 pixels: a small file can hold a picture
/// that fills the memory.
[[nodiscard]] Picture blank(int width, int height, int channels, int bits);

/// The first `channels` of each pixel: without alpha, or of three equal ones the first.
[[nodiscard]] Picture first_channels(const Picture& picture, int channels);

/// 0.299 R + 0.587 G + 0.114 B, rounded.
[[nodiscard]] Picture grey_of(const Picture& colour);

}  // namespace limber::images
