// SPDX-License-Identifier: MIT
#include "limber/frontend/image_reader.hpp"

#include "frontend/image_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/frontend/decode_image.hpp"

namespace limber {

GreyPixels ImageReader::read(const std::filesystem::path& file) {
  return grey_of(frontend::read_picture(file, camera_, Colours::kToGrey));
}

GreyPixels ImageReader::read(const EncodedImage& image, const std::string& place) {
  const int width = camera_.width, height = camera_.height;
  if (image.encoding.empty()) {
    const std::string_view file(reinterpret_cast<const char*>(image.data.data()), image.data.size());
    return grey_of(frontend::picture_of(file, width, height, Colours::kToGrey, place));
  }
  if (image.width != width || image.height != height) {
    throw frontend::other_size(place, width, height, {image.width, image.height});
  }
  return decode_grey(image, place);
}

GreyPixels ImageReader::grey_of(Picture picture) {
  const unsigned largest = picture.bits == 16 ? frontend::largest_number(picture) : 0U;
  while (largest >= 1U << bits_) bits_ += 2;
  const int width = picture.width, height = picture.height;
  return {width, height, frontend::highest_eight(std::move(picture), bits_)};
}

}  // namespace limber
