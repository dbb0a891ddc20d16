// SPDX-License-Identifier: MIT
// KITTI odometry folders: image_0, image_1, calib.txt, times.txt and poses.
#include <fmt/format.h>

#include <Eigen/LU>
#include <map>

#include "formats.hpp"
#include "io/image_size.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/trajectory_files.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

struct ProjectionMatrix {
  Eigen::Matrix<double, 3, 4> P;  // K [I | t]
  std::size_t line = 0;

  [[nodiscard]] Eigen::Vector3d translation() const { return P.leftCols<3>().inverse() * P.col(3); }
};

// The lines of calib.txt by their label, "P0:" and so on ("Tr:" has twelve numbers too).
std::map<std::string, ProjectionMatrix> read_projections(const fs::path& path) {
  TableReader table(path, {.separator = ' ', .names = {"label", "12 numbers"}, .counts = {13}});
  std::map<std::string, ProjectionMatrix> projections;
  while (table.next()) {
    ProjectionMatrix projection;
    projection.line = table.line();
    for (Eigen::Index k = 0; k < 12; ++k) {
      projection.P(k / 4, k % 4) = table.number(static_cast<std::size_t>(k) + 1);
    }
    if (!projections.emplace(table.field(0), projection).second) {
      table.fail("every label once", excerpt(table.field(0)) + " again");
    }
  }
  return projections;
}

const ProjectionMatrix& rectified(const std::map<std::string, ProjectionMatrix>& projections,
                                  const std::string& label, const fs::path& path) {
  const auto found = projections.find(label);
  if (found == projections.end()) {
    throw DataError(path.string(), 0, "a line that starts with " + label, "none");
  }
  const Eigen::Matrix3d K = found->second.P.leftCols<3>();
  Eigen::Matrix3d ideal = Eigen::Matrix3d::Identity();
  ideal.diagonal().head<2>() = K.diagonal().head<2>();
  ideal.col(2).head<2>() = K.col(2).head<2>();
  if (K != ideal) {
    throw DataError(path.string(), found->second.line, "a rectified projection (fu 0 cu, 0 fv cv, 0 0 1)",
                    "another 3x3 block");
  }
  if (!is_focal_length(K(0, 0)) || !is_focal_length(K(1, 1))) {
    throw DataError(path.string(), found->second.line, kFocalLengthsInWords,
                    fmt::format("{} and {}", K(0, 0), K(1, 1)));
  }
  return found->second;
}

Camera camera_of(const ProjectionMatrix& projection, const fs::path& first_image) {
  const ImageSize size = read_image_size(first_image);
  return {projection.P(0, 0), projection.P(1, 1), projection.P(0, 2), projection.P(1, 2),
          size.width,         size.height,        NoDistortion{}};
}

void read_kitti_calibration(const fs::path& folder, Recording& recording) {
  const fs::path path = folder / "calib.txt";
  const auto projections = read_projections(path);
  const ProjectionMatrix& left = rectified(projections, "P0:", path);
  const ProjectionMatrix& right = rectified(projections, "P1:", path);
  StereoCalibration& calibration = recording.calibration;
  calibration.body = BodyFrame::kCam0;
  calibration.cam0 = camera_of(left, recording.images.front().cam0);
  calibration.cam1 = camera_of(right, recording.images.front().cam1);
  // X_cam_k = X_rectified + t_k
  calibration.theta << Eigen::Vector3d::Zero(), right.translation() - left.translation();
  const std::string note = check_baseline(calibration.theta, path, right.line, "are P0 and P1 swapped?");
  if (!note.empty()) {
    recording.notes.push_back(note);
  }
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
  for (std::size_t k = 0; k < times.size(); ++k) {
    const ImagePair pair{times[k], image_path(folder / "image_0", k), image_path(folder / "image_1", k)};
    for (const fs::path& image : {pair.cam0, pair.cam1}) {
      if (!fs::is_regular_file(image)) {
        throw DataError(image.string(), 0,
                        fmt::format("an image for each of the {} times in times.txt", times.size()),
                        "no such file");
      }
    }
    recording.images.push_back(pair);
  }
  if (fs::exists(image_path(folder / "image_0", times.size()))) {
    throw DataError((folder / "times.txt").string(), 0, "a time for each image in image_0",
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

void read_kitti_truth(const fs::path& path, Recording& recording) {
  const auto poses = read_kitti_poses(path);
  if (poses.size() != recording.images.size()) {
    throw DataError(path.string(), 0,
                    fmt::format("{} poses, one for each image pair", recording.images.size()),
                    fmt::format("{}", poses.size()));
  }
  for (std::size_t k = 0; k < poses.size(); ++k) {
    GroundTruthState state;
    state.t_ns = recording.images[k].t_ns;
    state.R_world_body = so3_normalized(poses[k].T_world_body.R);
    state.p_world_body = poses[k].T_world_body.p;
    recording.groundtruth.push_back(state);
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
    read_kitti_truth(*poses, recording);
    note_if_cut_off(*poses, recording.notes);
  }
  if (const fs::path truth = folder / "calibration_truth.csv"; fs::exists(truth)) {
    recording.calibration_true = read_calibration_truth(truth);
    note_if_cut_off(truth, recording.notes);
  }
  return recording;
}

}  // namespace limber::detail
