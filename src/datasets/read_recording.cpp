// SPDX-License-Identifier: MIT
#include "limber/datasets/read_recording.hpp"

#include <fmt/format.h>

#include <array>

#include "formats.hpp"
#include "limber/core/errors.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

struct Format {
  const char* recognised_by;
  bool (*matches)(const fs::path& folder, const fs::path& mav0);
  Recording (*read)(const fs::path& folder, const fs::path& mav0);
};

// Tracks go before images: who matched the points already wants them used.
constexpr std::array<Format, 3> kFormats = {
    {{"mav0/tracks0 (track log)",
      [](const fs::path&, const fs::path& mav0) { return fs::exists(mav0 / "tracks0"); },
      [](const fs::path&, const fs::path& mav0) { return detail::read_track_log(mav0); }},
     {"mav0/cam0/data.csv (EuRoC with images)",
      [](const fs::path&, const fs::path& mav0) { return fs::exists(mav0 / "cam0" / "data.csv"); },
      [](const fs::path&, const fs::path& mav0) { return detail::read_euroc_images(mav0); }},
     {"image_0, or calib.txt and times.txt (KITTI odometry)",
      [](const fs::path& folder, const fs::path&) {
        return fs::exists(folder / "image_0") ||
               (fs::exists(folder / "calib.txt") && fs::exists(folder / "times.txt"));
      },
      [](const fs::path& folder, const fs::path&) { return detail::read_kitti_odometry(folder); }}}};

Recording read_any(const fs::path& folder) {
  const fs::path mav0 = fs::exists(folder / "mav0") ? folder / "mav0" : folder;
  std::string looked_for;
  for (const Format& format : kFormats) {
    if (format.matches(folder, mav0)) {
      return format.read(folder, mav0);
    }
    looked_for += (looked_for.empty() ? "" : "; or ") + std::string(format.recognised_by);
  }
  throw DataError(folder.string(), 0, "a recording, recognised by " + looked_for,
                  "none of these in the folder");
}

}  // namespace

Recording read_recording(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    throw DataError(path.string(), 0, "the folder of a recording",
                    fs::exists(path, error) ? "a file" : "no such folder");
  }
  try {
    Recording recording = read_any(path);
    const fs::path absolute = fs::canonical(path);
    recording.path = path;
    recording.name = (absolute.filename() == "mav0" ? absolute.parent_path() : absolute).filename().string();
    return recording;
  } catch (const fs::filesystem_error& e) {
    throw DataError(e.path1().empty() ? path.string() : e.path1().string(), 0, "a readable folder",
                    e.code().message());
  }
}

}  // namespace limber
