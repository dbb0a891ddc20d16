// SPDX-License-Identifier: MIT
#include "limber/datasets/recording_place.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>

#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/track_log.hpp"
#include "rig_files/euroc_text.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

bool nothing_at(const fs::path& path) {
  return !fs::exists(path) || (fs::is_directory(path) && fs::is_empty(path));
}

/// The true rig over time, beside a copy of another's recording that limber bent.
bool is_truth(const fs::path& file) {
  return fs::is_regular_file(file) && detail::load_text(file).starts_with(calibration_truth_text({}));
}

bool holds_only(const fs::path& folder, const std::set<fs::path>& names) {
  return fs::is_directory(folder) &&
         std::all_of(fs::directory_iterator(folder), fs::directory_iterator(),
                     [&](const fs::directory_entry& e) { return names.contains(e.path().filename()); });
}

bool holds_only_pictures(const fs::path& folder) {
  return !fs::exists(folder) ||
         std::all_of(fs::directory_iterator(folder), fs::directory_iterator(),
                     [](const fs::directory_entry& e) { return e.path().extension() == ".png"; });
}

/// By the mark in its calibration; and nothing of anybody else's in it.
bool is_mav0_by_limber(const fs::path& mav0) {
  const fs::path yaml = mav0 / "cam0" / "sensor.yaml";
  if (!fs::is_regular_file(yaml) ||
      detail::load_text(yaml).find(detail::kIntrinsicsMark) == std::string::npos ||
      !holds_only(mav0, {"cam0", "cam1", "imu0", "odometry0", "tracks0", "landmarks0", "scene0", "mocap0",
                         "state_groundtruth_estimate0", "calibration_truth0"})) {
    return false;
  }
  for (const fs::directory_entry& sensor : fs::directory_iterator(mav0)) {
    if (sensor.path().filename() != "scene0" && (!holds_only(sensor, {"data.csv", "sensor.yaml", "data"}) ||
                                                 !holds_only_pictures(sensor.path() / "data"))) {
      return false;
    }
  }
  return true;
}

bool is_recording_by_limber(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    return false;
  }
  if (const fs::path mav0 = folder / "mav0"; fs::exists(mav0)) {
    return (is_mav0_by_limber(mav0) || is_truth(mav0 / "calibration_truth0" / "data.csv")) &&
           holds_only(folder, {"mav0"});
  }
  return is_truth(folder / "calibration_truth.csv") && holds_only(folder, names_in_kitti_folder());
}

void require_place(const fs::path& path, const char* expected, bool own, bool replace) {
  if (!nothing_at(path) && !(own && replace)) {
    throw DataError(path.string(), 0, expected,
                    own ? "a recording that limber wrote; --force replaces it"
                        : "something that limber did not write, or not alone");
  }
}

}  // namespace

const std::set<fs::path>& names_in_kitti_folder() {
  static const std::set<fs::path> names = {"image_0",   "image_1",   "image_2",   "image_3",
                                           "calib.txt", "times.txt", "poses.txt", "calibration_truth.csv"};
  return names;
}

bool lies_in_mav0(const fs::path& folder) {
  std::error_code ignored;
  const fs::path place = fs::weakly_canonical(fs::absolute(folder), ignored);
  return std::ranges::find(place, fs::path("mav0")) != place.end();
}

void require_place_for_mav0(const fs::path& folder, bool replace) {
  if (lies_in_mav0(folder)) {
    throw DataError(folder.string(), 0, "a folder for a recording of its own", "one within a recording");
  }
  const fs::path mav0 = folder / "mav0";
  require_place(mav0, "no folder of this name", is_mav0_by_limber(mav0), replace);
}

void require_place_for_recording(const fs::path& folder, bool replace) {
  require_place(folder, "no folder of this name, or an empty one", is_recording_by_limber(folder), replace);
}

}  // namespace limber
