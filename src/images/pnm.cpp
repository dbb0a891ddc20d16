// SPDX-License-Identifier: MIT
// PGM and PPM: binary and text (https://netpbm.sourceforge.net/doc/pgm.html).
#include <bit>
#include <cctype>
#include <charconv>
#include <cstring>
#include <stdexcept>

#include "images/codecs.hpp"
#include "images/samples.hpp"

namespace limber::images {
namespace {

/// Takes numbers between blanks and comments.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}

  unsigned number() {
    skip_blanks();
    unsigned value = 0;
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (error != std::errc())
      throw std::runtime_error("a PGM or PPM file without a number where one belongs");
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return value;
  }

  /// What follows the one blank after the last number.
  [[nodiscard]] std::string_view rest() const { return text_.empty() ? text_ : text_.substr(1); }

 private:
  void skip_blanks() {
    while (!text_.empty() && (std::isspace(static_cast<unsigned char>(text_[0])) != 0 || text_[0] == '#')) {
      text_.remove_prefix(text_[0] == '#' ? std::min(text_.find('\n'), text_.size() - 1) + 1 : 1);
    }
  }

  std::string_view text_;
};

void store(Picture& picture, std::size_t k, unsigned value) {
  if (picture.bits == 8) {
    picture.data[k] = static_cast<std::uint8_t>(value);
  } else {
    const auto sample = static_cast<std::uint16_t>(value);
    std::memcpy(picture.data.data() + 2 * k, &sample, 2);
  }
}

}  // namespace

bool is_pnm(std::string_view file) {
  return file.size() > 2 && file[0] == 'P' &&
         (file[1] == '2' || file[1] == '3' || file[1] == '5' || file[1] == '6');
}

Picture decode_pnm(std::string_view file) {
  Words words(file.substr(2));
  const unsigned width = words.number(), height = words.number(), most = words.number();
  constexpr unsigned kLargest = 100'000;
  if (width == 0 || height == 0 || width > kLargest || height > kLargest || most == 0 || most > 65535) {
    throw std::runtime_error("a PGM or PPM file of no size or range that there is");
  }
  const bool text = file[1] < '4', colour = file[1] == '3' || file[1] == '6';
  Picture picture =
      blank(static_cast<int>(width), static_cast<int>(height), colour ? 3 : 1, most > 255 ? 16 : 8);
  const std::size_t bytes = most > 255 ? 2 : 1, samples = picture.data.size() / bytes;
  if (text) {
    for (std::size_t k = 0; k < samples; ++k) store(picture, k, std::min(words.number(), most));
    return picture;
  }
  const std::string_view data = words.rest();
  if (data.size() < picture.data.size()) throw std::runtime_error("a PGM or PPM file that was cut off");
  std::memcpy(picture.data.data(), data.data(), picture.data.size());
  if (bytes == 2 && std::endian::native == std::endian::little) {
    for (std::size_t k = 0; k < samples; ++k) std::swap(picture.data[2 * k], picture.data[2 * k + 1]);
  }
  return picture;
}

}  // namespace limber::images
