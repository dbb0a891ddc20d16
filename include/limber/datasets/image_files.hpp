// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "limber/datasets/recording.hpp"

namespace limber {

/// The images of a recording as they are stored: its own ImageStore, or the bytes of its files.
[[nodiscard]] std::shared_ptr<const ImageStore> stored_images(const Recording& recording);

}  // namespace limber
