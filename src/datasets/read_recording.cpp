// SPDX-License-Identifier: MIT
#include "limber/datasets/read_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "formats.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/nearest_word.hpp"
#include "limber/datasets/recording_place.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

bool is_raw_drive(const fs::path& folder) {
  return fs::exists(folder / "image_00" / "timestamps.txt") ||
         fs::exists(folder / "image_02" / "timestamps.txt");
}

struct Format {
  const char* recognised_by;
  bool (*matches)(const fs::path& folder, const fs::path& mav0);
  Recording (*read)(const fs::path& folder, const fs::path& mav0);
};

// Tracks go before images: who matched the points already wants them used.
constexpr std::array<Format, 4> kFormats = {
    {{"mav0/tracks0 (track log)",
      [](const fs::path&, const fs::path& mav0) { return fs::exists(mav0 / "tracks0"); },
      [](const fs::path&, const fs::path& mav0) { return detail::read_track_log(mav0); }},
     {"mav0/cam0/data.csv (EuRoC or TUM-VI with images)",
      [](const fs::path&, const fs::path& mav0) { return fs::exists(mav0 / "cam0" / "data.csv"); },
      [](const fs::path&, const fs::path& mav0) { return detail::read_euroc_images(mav0); }},
     {"image_0 or image_2, or calib.txt and times.txt (KITTI odometry)",
      [](const fs::path& folder, const fs::path&) {
        return fs::exists(folder / "image_0") || fs::exists(folder / "image_2") ||
               (fs::exists(folder / "calib.txt") && fs::exists(folder / "times.txt"));
      },
      [](const fs::path& folder, const fs::path&) { return detail::read_kitti_odometry(folder); }},
     {"image_00 or image_02 with data and timestamps.txt (KITTI raw drive)",
      [](const fs::path& folder, const fs::path&) { return is_raw_drive(folder); },
      [](const fs::path& folder, const fs::path&) { return detail::read_kitti_raw(folder); }}}};

/// What a file may be that was given where a folder was expected, and what to do with it.
struct Hint {
  std::string_view ending, what;
};
// What are bags is read by limber::bags, and does not come here.
constexpr const char* kOtherBag =
    "a file that does not begin like a bag of its ending: ROS 1 (version 2.0), MCAP or ROS 2 (db3); 'rosbag "
    "fix' "
    "brings older ROS 1 bags up to date";
constexpr std::array<Hint, 16> kHints = {
    {{".bag", kOtherBag},
     {".mcap", kOtherBag},
     {".db3", kOtherBag},
     {".zstd", "a file that holds no bag packed by zstd, or a damaged one"},
     {".zip", "an archive: unpack it and give the folder"},
     {".gz", "an archive: unpack it and give the folder or the bag"},
     {".tar", "an archive: unpack it and give the folder"},
     {".yaml", "a calibration or settings: --calib and --imu take it, beside a recording"},
     {".yml", "a calibration or settings: --calib takes it, beside a recording"},
     {".json", "a calibration: --calib takes it, beside a recording"},
     {".mp4", "a video: without stamps and IMU it is no recording; its images in an EuRoC folder are one"},
     {".mkv", "a video: without stamps and IMU it is no recording; its images in an EuRoC folder are one"},
     {".svo", "a ZED recording: export it to a ROS bag with ZED's tools"},
     {".txt", "a text file: 'limber evaluate' takes trajectories; a recording is a folder"},
     {".tum", "a trajectory: 'limber evaluate' takes it; a recording is a folder"},
     {".csv", "a table: 'limber evaluate' takes trajectories; a recording is the folder with mav0 in it"}}};

std::string what_a_file_is(const fs::path& path) {
  const std::string ending = in_lower_case(path.extension().string());
  const auto hint =
      std::find_if(kHints.begin(), kHints.end(), [&](const Hint& known) { return known.ending == ending; });
  return hint == kHints.end() ? "a file of a kind that limber does not know" : std::string(hint->what);
}

/// By name, of a folder that holds KITTI raw drives; nothing if it holds none.
std::optional<fs::path> first_drive(const fs::path& folder) {
  std::optional<fs::path> first;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (is_raw_drive(entry.path()) && (!first || entry.path() < *first)) {
      first = entry.path();
    }
  }
  return first;
}

fs::path mav0_of(const fs::path& folder) { return fs::exists(folder / "mav0") ? folder / "mav0" : folder; }

Recording read_any(const fs::path& folder) {
  const fs::path mav0 = mav0_of(folder);
  std::string looked_for;
  for (const Format& format : kFormats) {
    if (format.matches(folder, mav0)) {
      return format.read(folder, mav0);
    }
    looked_for += (looked_for.empty() ? "" : "; or ") + std::string(format.recognised_by);
  }
  const std::optional<fs::path> drive = first_drive(folder);
  looked_for += "; or .db3 or .mcap files, or metadata.yaml (ROS 2 bag)";  // read by limber::bags
  throw DataError(folder.string(), 0, "a recording, recognised by " + looked_for,
                  drive ? "a day of KITTI raw drives: give one of them, " + drive->string()
                        : "none of these in the folder");
}

}  // namespace

bool holds_recording(const fs::path& folder) {
  try {
    if (!fs::is_directory(folder)) {
      return false;
    }
    const fs::path mav0 = mav0_of(folder);
    return fs::exists(folder / "metadata.yaml") || first_drive(folder).has_value() ||
           std::any_of(kFormats.begin(), kFormats.end(),
                       [&](const Format& format) { return format.matches(folder, mav0); });
  } catch (const fs::filesystem_error&) {
    return false;
  }
}

Recording read_recording(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    throw DataError(path.string(), 0, "the folder of a recording, or a bag",
                    fs::exists(path, error) ? what_a_file_is(path) : "no such file or folder");
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
