// SPDX-License-Identifier: MIT
#include "limber/datasets/write_euroc.hpp"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

#include "copied_images.hpp"
#include "euroc_folder.hpp"
#include "io/table_text.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/recording_place.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

std::string_view text_of(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

std::vector<LostImage> write_euroc(const Recording& recording, const fs::path& folder,
                                   const ImageFileOf& file_of, bool replace,
                                   const std::function<void(std::size_t)>& progress,
                                   const std::function<bool()>& stop) {
  if (recording.images.empty()) {
    throw std::invalid_argument("write_euroc: the recording has no images");
  }
  try {
    const FolderUnlessEmpty outer(folder);
    require_place_for_mav0(folder, replace);
    detail::EurocFolder mav0(folder / "mav0");
    mav0.write_cameras(recording.calibration);
    mav0.write_imu(recording);
    mav0.write_odometry(recording);
    mav0.write_groundtruth(recording);
    detail::CopiedImages images(recording, [&](EncodedImage image, const std::string& place) {
      if (!image.encoding.empty()) {
        image.data = file_of(image, place);
      }
      return image;
    });
    std::array<detail::TableText, 2> lists = {detail::TableText("images", ','),
                                              detail::TableText("images", ',')};
    for (detail::TableText& list : lists) {
      list.header("#timestamp [ns],filename");
    }
    for (std::size_t n = 0; n < recording.images.size(); ++n) {
      if (stop && stop()) {
        throw std::runtime_error("stopped: nothing is written");
      }
      for (std::size_t c = 0; c < 2; ++c) {
        const auto image = images.take(c, n);
        if (!image) {
          continue;
        }
        const std::string_view bytes = text_of(image->data);
        const std::string name =
            fmt::format("{}.{}", recording.images[n].t_ns, bytes.starts_with("\xff\xd8") ? "jpg" : "png");
        mav0.write(fmt::format("cam{}/data", c), name, bytes);
        lists[c].time(recording.images[n].t_ns);
        lists[c].cell(std::string_view(name));
        lists[c].end_row();
      }
      if (progress) {
        progress(n + 1);
      }
    }
    mav0.write("cam0", "data.csv", lists[0].text());
    mav0.write("cam1", "data.csv", lists[1].text());
    mav0.commit();
    return images.lost();
  } catch (const fs::filesystem_error& e) {
    throw DataError((folder / "mav0").string(), 0, "a place where folders and files can be written",
                    e.code().message());
  }
}

}  // namespace limber
