// SPDX-License-Identifier: MIT
// KITTI odometry folders: image_0, image_1 (or image_2, image_3), calib.txt, times.txt and poses.
#include <fmt/format.h>

#include <Eigen/LU>
#include <map>

#include "formats.hpp"
#include "image_checks.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

void set_size(Camera& camera, const ImageSize& size) {
  camera.width = size.width;
  camera.height = size.height;
}

// Without the grey images the colour ones are taken.
bool is_colour(const fs::path& folder) {
  return !fs::exists(folder / "image_0") && fs::exists(folder / "image_2");
}

void read_kitti_calibration(const fs::path& folder, Recording& recording) {
  RigFile rig = read_kitti_odometry_rig(folder / "calib.txt", is_colour(folder));
  set_size(rig.calibration.cam0, usual_image(recording, 0).size);
  set_size(rig.calibration.cam1, usual_image(recording, 1).size);
  recording.calibration = rig.calibration;
  recording.notes.insert(recording.notes.end(), rig.notes.begin(), rig.notes.end());
}

std::vector<std::int64_t> read_times(const fs::path& path) {
  TableReader table(path, {.separator = ' ', .names = {"time [s]"}, .counts = {1}});
  std::vector<std::int64_t> times;
  while (table.next()) {
    const auto t_ns = parse_seconds_as_ns(table.field(0));
    if (!t_ns) {
      table.fail("a time in seconds", excerpt(table.field(0)));
    }
    table.require_later(*t_ns);
    times.push_back(*t_ns);
  }
  table.require_a_row("time");
  return times;
}

// image_0/000000.png or .jpg; the path with .png if there is neither.
fs::path image_path(const fs::path& camera, std::size_t index) {
  const fs::path jpg = camera / fmt::format("{:06}.jpg", index);
  return fs::exists(jpg) ? jpg : camera / fmt::format("{:06}.png", index);
}

void read_images(const fs::path& folder, Recording& recording) {
  const auto times = read_times(folder / "times.txt");
  const std::string left = is_colour(folder) ? "image_2" : "image_0";
  const std::string right = is_colour(folder) ? "image_3" : "image_1";
  std::vector<DataError> missing;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const ImagePair pair{times[k], image_path(folder / left, k), image_path(folder / right, k)};
    if (const bool has_left = is_image_file(pair.cam0); !has_left || !is_image_file(pair.cam1)) {
      missing.emplace_back((has_left ? pair.cam1 : pair.cam0).string(), 0,
                           fmt::format("an image for each of the {} times in times.txt", times.size()),
                           "no such file");
    }
    recording.images.push_back(pair);
  }
  require_most_images(recording, missing);
  if (fs::exists(image_path(folder / left, times.size()))) {
    throw DataError((folder / "times.txt").string(), 0, "a time for each image in " + left,
                    fmt::format("{} times and more images", times.size()));
  }
}

// KITTI's own layout keeps the poses of sequences/06 in poses/06.txt.
std::optional<fs::path> poses_path(const fs::path& folder) {
  const fs::path beside = folder / "poses.txt";
  const fs::path original =
      folder / ".." / ".." / "poses" / (fs::canonical(folder).filename().string() + ".txt");
  return fs::exists(beside)     ? std::optional<fs::path>(beside)
         : fs::exists(original) ? std::optional<fs::path>(original)
                                : std::nullopt;
}

// @param T_cam0_body  the poses are those of the left grey camera
void read_kitti_truth(const fs::path& path, const Pose& T_cam0_body, Recording& recording) {
  const auto poses = read_kitti_poses(path);
  if (poses.size() != recording.images.size()) {
    throw DataError(path.string(), 0,
                    fmt::format("{} poses, one for each image pair", recording.images.size()),
                    fmt::format("{}", poses.size()));
  }
  for (std::size_t k = 0; k < poses.size(); ++k) {
    GroundTruthState state;
    state.t_ns = recording.images[k].t_ns;
    const Pose T_world_body = poses[k].T_world_body * T_cam0_body;
    state.R_world_body = so3_normalized(T_world_body.R);
    state.p_world_body = T_world_body.p;
    recording.truth.motion.states.push_back(state);
  }
}

}  // namespace

Eigen::Matrix3d R_zup_kitti() {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

Recording read_kitti_odometry(const fs::path& folder) {
  Recording recording;
  read_images(folder, recording);
  read_kitti_calibration(folder, recording);
  note_if_cut_off(folder / "times.txt", recording.notes);
  note_if_cut_off(folder / "calib.txt", recording.notes);
  if (const auto poses = poses_path(folder)) {
    read_kitti_truth(*poses, is_colour(folder) ? kitti_colour_camera(folder / "calib.txt") : Pose{},
                     recording);
    note_if_cut_off(*poses, recording.notes);
  }
  if (const fs::path truth = folder / "calibration_truth.csv"; fs::exists(truth)) {
    recording.truth.rig = read_calibration_truth(truth);
    note_if_cut_off(truth, recording.notes);
  }
  return recording;
}

}  // namespace limber::detail
