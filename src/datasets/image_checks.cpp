// SPDX-License-Identifier: MIT
#include "image_checks.hpp"

#include <algorithm>
#include <optional>
#include <system_error>

namespace limber::detail {

namespace fs = std::filesystem;

bool is_image_file(const fs::path& path) {
  std::error_code unreadable;
  return fs::is_regular_file(path, unreadable);
}

void require_most_images(const Recording& recording, const std::vector<DataError>& missing) {
  if (2 * missing.size() > recording.images.size()) {
    throw missing.front();
  }
}

UsualImage usual_image(const Recording& recording, std::size_t camera) {
  constexpr std::size_t kLooked = 9;
  struct Seen {
    UsualImage image;
    std::size_t count;
  };
  std::vector<Seen> sizes;
  std::optional<DataError> first_error;
  const std::size_t pairs = recording.images.size(), looked = std::min(kLooked, pairs);
  for (std::size_t k = 0; k < looked; ++k) {
    const ImagePair& pair = recording.images[k * pairs / looked];
    const fs::path& file = camera == 0 ? pair.cam0 : pair.cam1;
    try {
      const ImageSize size = read_image_size(file);
      const auto same = std::find_if(sizes.begin(), sizes.end(), [&](const Seen& seen) {
        return seen.image.size.width == size.width && seen.image.size.height == size.height;
      });
      same == sizes.end() ? sizes.push_back({{file, size}, 1}) : void(++same->count);
    } catch (const DataError& error) {
      if (!first_error) first_error = error;
    }
  }
  if (sizes.empty()) {
    throw first_error.value();
  }
  return std::max_element(sizes.begin(), sizes.end(),
                          [](const Seen& a, const Seen& b) { return a.count < b.count; })
      ->image;
}

}  // namespace limber::detail
