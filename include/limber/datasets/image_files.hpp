// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "limber/datasets/recording.hpp"

namespace limber {

/// Where so many pairs at the begin of a recording, or all, cannot be read, that is not damage.
inline constexpr std::size_t kFirstPairs = 10;

/// What becomes of an image on its way; empty: it stays as it is stored. `place` is for messages.
using ImageChange = std::function<EncodedImage(EncodedImage, const std::string& place)>;

/// An image that a copy of a recording does not hold.
struct LostImage {
  std::size_t camera = 0;  ///< 0 or 1
  std::int64_t t_ns = 0;   ///< of its pair
  std::string why;         ///< file, where in it, what was expected and found
};

/// The images of a recording as they are stored: its own ImageStore, or the bytes of its files.
[[nodiscard]] std::shared_ptr<const ImageStore> stored_images(const Recording& recording);

}  // namespace limber
