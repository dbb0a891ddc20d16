// SPDX-License-Identifier: MIT
#include "limber/decalibrate/bend_images.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "decalibrate/rotation_warp.hpp"
#include "frontend/image_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/recording_place.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/images/picture.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

/// Where the parts of a recording with images are.
struct Layout {
  fs::path root;                    ///< of what is copied, in the recording
  fs::path inner;                   ///< the same in the new folder
  fs::path right_images;            ///< in the new folder
  fs::path truth;                   ///< in the new folder
  std::vector<fs::path> made_anew;  ///< relative to root: not copied
  fs::path list;                    ///< of the right images, in the new folder; empty if there is none
  std::set<fs::path> parts = {};    ///< of the recording, by name; empty: all that is there
};

Layout layout_of(const Recording& recording) {
  const bool has_mav0 = fs::exists(recording.path / "mav0");
  if (has_mav0 || fs::exists(recording.path / "cam0" / "data.csv")) {
    return {has_mav0 ? recording.path / "mav0" : recording.path,
            "mav0",
            "mav0/cam1/data",
            "mav0/calibration_truth0/data.csv",
            {"cam1/data", "cam1/data.csv", "calibration_truth0"},
            "mav0/cam1/data.csv"};
  }
  if (!fs::exists(recording.path / "image_0") && !fs::exists(recording.path / "image_2")) {
    throw DataError(recording.path.string(), 0, "an EuRoC or a KITTI odometry folder",
                    "images in another one: limber convert makes an EuRoC folder of it");
  }
  const char* const right = fs::exists(recording.path / "image_0") ? "image_1" : "image_3";
  return {recording.path,         "", right, "calibration_truth.csv", {right, "calibration_truth.csv"}, "",
          names_in_kitti_folder()};
}

/// The recording but for what is made anew; links are followed, so that the copy stands on its own.
void copy_rest(const Layout& layout, const fs::path& folder) {
  for (auto entry =
           fs::recursive_directory_iterator(layout.root, fs::directory_options::follow_directory_symlink);
       entry != fs::recursive_directory_iterator(); ++entry) {
    const fs::path relative = entry->path().lexically_relative(layout.root);
    const bool is_part = layout.parts.empty() || layout.parts.contains(*relative.begin());
    if (!is_part ||
        std::find(layout.made_anew.begin(), layout.made_anew.end(), relative) != layout.made_anew.end()) {
      entry.disable_recursion_pending();
    } else if (entry->is_regular_file()) {
      const fs::path to = folder / layout.inner / relative;
      fs::create_directories(to.parent_path());
      fs::copy_file(entry->path(), to);
    }
  }
}

/// KITTI's own layout keeps the poses elsewhere.
void copy_poses(const Recording& recording, const fs::path& folder) {
  const fs::path original =
      recording.path / ".." / ".." / "poses" / (fs::canonical(recording.path).filename().string() + ".txt");
  if (fs::exists(recording.path / "image_0") && !fs::exists(recording.path / "poses.txt") &&
      fs::exists(original)) {
    fs::copy_file(original, folder / "poses.txt");
  }
}

void write_png(const fs::path& file, const cv::Mat& image) {
  const int bits = image.depth() == CV_16U ? 16 : 8;
  const auto bytes = encode_png({image.cols, image.rows, image.channels(), bits, image.step, image.data});
  write_staged_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

ImageBending bend_images(const Recording& recording, const BentRig& rig, const fs::path& folder,
                         const std::function<void(std::size_t)>& progress,
                         const std::function<bool()>& stop) {
  if (recording.images.empty()) throw std::invalid_argument("bend_images: the recording has no images");
  const Layout layout = layout_of(recording);
  copy_rest(layout, folder);
  copy_poses(recording, folder);
  const Camera& camera = recording.calibration.cam1;
  decalibrate::RotationWarp warp(camera);
  ImageBending result;
  std::string list = "#timestamp [ns],filename\n";
  for (const ImagePair& pair : recording.images) {
    if (stop && stop()) throw std::runtime_error("stopped: nothing is written");
    Picture sound = frontend::read_picture(pair.cam1, camera, Colours::kKeep);
    const cv::Mat pixels(sound.height, sound.width,
                         CV_MAKETYPE(sound.bits == 16 ? CV_16U : CV_8U, sound.channels), sound.data.data());
    const cv::Mat bent = warp(pixels, rig.turn_of_cam1(pair.t_ns));
    const std::string name = pair.cam1.stem().string() + ".png";
    write_png(folder / layout.right_images / name, bent);
    list += fmt::format("{},{}\n", pair.t_ns, name);
    result.black_mean += warp.black_share() / static_cast<double>(recording.images.size());
    result.black_largest = std::max(result.black_largest, warp.black_share());
    ++result.images;
    if (progress) progress(result.images);
  }
  if (!layout.list.empty()) write_staged_file(folder / layout.list, list);
  write_staged_file(folder / layout.truth, calibration_truth_text(rig.truth()));
  return result;
}

}  // namespace limber
