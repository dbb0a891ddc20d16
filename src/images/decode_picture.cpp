// SPDX-License-Identifier: MIT
#include <stdexcept>

#include "images/codecs.hpp"
#include "images/samples.hpp"
#include "limber/core/errors.hpp"

namespace limber {
namespace {

Picture decoded(std::string_view file, Colours colours) {
  if (images::is_png(file)) return images::decode_png(file);
  if (images::is_jpeg(file)) return images::decode_jpeg(file, colours);
  if (images::is_tiff(file)) return images::decode_tiff(file);
  if (images::is_pnm(file)) return images::decode_pnm(file);
  throw std::runtime_error("another format");
}

}  // namespace

Picture decode_picture(std::string_view file, Colours colours, const std::string& name) {
  try {
    Picture picture = decoded(file, colours);
    return colours == Colours::kToGrey && picture.channels == 3 ? images::grey_of(picture) : picture;
  } catch (const std::runtime_error& error) {
    throw DataError(name, 0, "a PNG, JPEG, TIFF, PGM or PPM image", error.what());
  }
}

}  // namespace limber
