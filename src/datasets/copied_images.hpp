// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "limber/datasets/image_files.hpp"

namespace limber::detail {

/// The images of a recording for a copy of it, pair after pair. One that cannot be read, or changed, is lost:
/// the copy goes on without it.
class CopiedImages {
 public:
  /// @param recording  must outlive this
  CopiedImages(const Recording& recording, ImageChange change);

  /// Nothing of a lost one.
  /// @throws DataError where the first kFirstPairs of this camera, or all, are so
  [[nodiscard]] std::optional<EncodedImage> take(std::size_t camera, std::size_t pair);

  [[nodiscard]] const std::vector<LostImage>& lost() const { return lost_; }

 private:
  const Recording& recording_;
  std::shared_ptr<const ImageStore> images_;
  ImageChange change_;
  std::array<bool, 2> any_taken_ = {};
  std::vector<LostImage> lost_;
};

}  // namespace limber::detail
