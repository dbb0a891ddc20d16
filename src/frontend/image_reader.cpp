// SPDX-License-Identifier: MIT
#include "limber/frontend/image_reader.hpp"

#include "frontend/image_file.hpp"

namespace limber {

GreyPixels ImageReader::read(const std::filesystem::path& file) {
  Picture picture = frontend::read_picture(file, camera_, Colours::kToGrey);
  const unsigned largest = picture.bits == 16 ? frontend::largest_number(picture) : 0U;
  while (largest >= 1U << bits_) bits_ += 2;
  const int width = picture.width, height = picture.height;
  return {width, height, frontend::highest_eight(std::move(picture), bits_)};
}

}  // namespace limber
