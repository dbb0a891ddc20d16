// SPDX-License-Identifier: MIT
#include "copied_images.hpp"

#include <utility>

#include "limber/core/errors.hpp"

namespace limber::detail {

CopiedImages::CopiedImages(const Recording& recording, ImageChange change)
    : recording_(recording), images_(stored_images(recording)), change_(std::move(change)) {}

std::optional<EncodedImage> CopiedImages::take(std::size_t camera, std::size_t pair) {
  try {
    EncodedImage image = images_->load(camera, pair);
    if (change_) {
      image = change_(std::move(image), images_->place(camera, pair));
    }
    any_taken_[camera] = true;
    return image;
  } catch (const DataError& error) {
    const std::size_t seen = pair + 1;
    if (!any_taken_[camera] && (seen == kFirstPairs || seen == recording_.images.size())) {
      throw;
    }
    lost_.push_back({camera, recording_.images[pair].t_ns, error.what()});
    return std::nullopt;
  }
}

}  // namespace limber::detail
