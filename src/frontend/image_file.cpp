// SPDX-License-Identifier: MIT
#include "frontend/image_file.hpp"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>

namespace limber::frontend {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

namespace {

std::uint16_t sixteen(const Picture& picture, std::size_t k) {
  std::uint16_t value = 0;
  std::memcpy(&value, picture.data.data() + 2 * k, 2);
  return value;
}

}  // namespace

DataError other_size(const std::string& name, int width, int height, const detail::ImageSize& found) {
  return {name, 0, "an image of " + size_text(width, height) + " (the calibration's resolution)",
          size_text(found.width, found.height)};
}

Picture picture_of(std::string_view file, int width, int height, Colours colours, const std::string& name) {
  const std::string expected = "an image of " + size_text(width, height);
  // Before the pixels are unpacked: a small file can hold a picture that fills the memory.
  if (file.empty()) {
    throw DataError(name, 0, expected, "an empty file");
  }
  std::istringstream header{std::string(file)};
  if (const auto size = detail::image_size_of(header);
      size && (size->width != width || size->height != height)) {
    throw other_size(name, width, height, *size);
  } else if (!size) {
    throw DataError(name, 0, expected,
                    "nothing that can be decoded as an image: no PNG, JPEG, TIFF, PGM or PPM");
  }
  return decode_picture(file, colours, name);
}

Picture read_picture(const std::filesystem::path& file, const Camera& camera, Colours colours) {
  std::error_code no_error_wanted;
  std::ifstream in;
  if (std::filesystem::is_regular_file(file, no_error_wanted)) {  // to open a pipe is to wait for it
    in.open(file, std::ios::binary);
  }
  if (!in.is_open()) {
    throw DataError(file.string(), 0, "an image of " + size_text(camera.width, camera.height),
                    "no readable file");
  }
  std::ostringstream content;
  content << in.rdbuf();
  return picture_of(content.view(), camera.width, camera.height, colours, file.string());
}

unsigned largest_number(const Picture& picture) {
  if (picture.bits == 8) return *std::max_element(picture.data.begin(), picture.data.end());
  std::uint16_t largest = 0;
  for (std::size_t k = 0; k < picture.data.size() / 2; ++k) largest = std::max(largest, sixteen(picture, k));
  return largest;
}

std::vector<std::uint8_t> highest_eight(Picture picture, int bits) {
  if (picture.bits == 8) return std::move(picture.data);
  std::vector<std::uint8_t> out(picture.data.size() / 2);
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = static_cast<std::uint8_t>(sixteen(picture, k) >> (bits - 8));
  }
  return out;
}

}  // namespace limber::frontend
