// SPDX-License-Identifier: MIT
#include "limber/datasets/image_files.hpp"

#include <fstream>
#include <iterator>

#include "image_checks.hpp"
#include "limber/core/errors.hpp"

namespace limber {
namespace {

/// Image files, as they lie there.
class ImageFiles final : public ImageStore {
 public:
  explicit ImageFiles(std::vector<ImagePair> pairs) : pairs_(std::move(pairs)) {}

  [[nodiscard]] EncodedImage load(std::size_t camera, std::size_t pair) const override {
    const std::filesystem::path& path = file(camera, pair);
    std::ifstream stream;
    if (detail::is_image_file(path)) {
      stream.open(path, std::ios::binary);
    }
    if (!stream.is_open()) {
      throw DataError(path.string(), 0, "a readable image", "no readable file");
    }
    EncodedImage out;
    out.data.assign(std::istreambuf_iterator<char>(stream), {});
    if (out.data.empty()) {
      throw DataError(place(camera, pair), 0, "a readable image", "an empty file");
    }
    return out;
  }
  [[nodiscard]] std::string place(std::size_t camera, std::size_t pair) const override {
    return file(camera, pair).string();
  }

 private:
  [[nodiscard]] const std::filesystem::path& file(std::size_t camera, std::size_t pair) const {
    return camera == 0 ? pairs_.at(pair).cam0 : pairs_.at(pair).cam1;
  }

  std::vector<ImagePair> pairs_;
};

}  // namespace

std::shared_ptr<const ImageStore> stored_images(const Recording& recording) {
  return recording.image_store ? recording.image_store : std::make_shared<ImageFiles>(recording.images);
}

}  // namespace limber
