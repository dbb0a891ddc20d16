// SPDX-License-Identifier: MIT
// KITTI's calib.txt (odometry) and calib_cam_to_cam.txt (raw): lines of a label and numbers.
#include <fmt/format.h>

#include <Eigen/LU>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include "io/numbers.hpp"
#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

namespace fs = std::filesystem;

/// The lines of a file by their label.
class LabelledNumbers {
 public:
  explicit LabelledNumbers(fs::path path) : path_(std::move(path)) {
    std::istringstream text(load_text(path_));
    std::string row;
    for (std::size_t line = 1; std::getline(text, row); ++line) {
      std::istringstream words(row);
      std::string label;
      words >> label;
      if (label.empty() || label.front() == '#') {
        continue;
      }
      std::vector<std::string> values;
      for (std::string word; words >> word;) {
        values.push_back(word);
      }
      if (!lines_.emplace(label, Line{std::move(values), line}).second) {
        throw DataError(path_.string(), line, "every label once", excerpt(label) + " again");
      }
    }
  }

  [[nodiscard]] const fs::path& path() const { return path_; }
  [[nodiscard]] bool has(const std::string& label) const { return lines_.contains(label); }
  [[nodiscard]] std::size_t line(const std::string& label) const { return required(label).number; }

  [[nodiscard]] std::vector<double> numbers(const std::string& label, std::size_t count) const {
    const Line& line = required(label);
    if (line.values.size() != count) {
      fail(label, fmt::format("{} with {} numbers", label, count), fmt::format("{}", line.values.size()));
    }
    std::vector<double> out;
    for (const std::string& word : line.values) {
      const auto value = parse_number(word);
      if (!value || !std::isfinite(*value)) {
        fail(label, "a finite number in " + label, excerpt(word));
      }
      out.push_back(*value);
    }
    return out;
  }

  [[nodiscard]] Eigen::MatrixXd matrix(const std::string& label, Eigen::Index rows, Eigen::Index cols) const {
    const auto values = numbers(label, static_cast<std::size_t>(rows * cols));
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(values.data(), rows, cols);
  }

  [[noreturn]] void fail(const std::string& label, const std::string& expected,
                         const std::string& found) const {
    throw DataError(path_.string(), line(label), expected, found);
  }

 private:
  struct Line {
    std::vector<std::string> values;
    std::size_t number;
  };

  [[nodiscard]] const Line& required(const std::string& label) const {
    const auto found = lines_.find(label);
    if (found == lines_.end()) {
      throw DataError(path_.string(), 0, "a line that starts with " + label, "none");
    }
    return found->second;
  }

  fs::path path_;
  std::map<std::string, Line> lines_;
};

Camera pinhole_of(const LabelledNumbers& file, const std::string& label, const Eigen::Matrix3d& K) {
  Eigen::Matrix3d ideal = Eigen::Matrix3d::Identity();
  ideal.diagonal().head<2>() = K.diagonal().head<2>();
  ideal.col(2).head<2>() = K.col(2).head<2>();
  if (K != ideal) {
    file.fail(label, "a rectified projection, or a camera matrix, (fu 0 cu, 0 fv cv, 0 0 1)",
              "another 3x3 block");
  }
  if (!is_focal_length(K(0, 0)) || !is_focal_length(K(1, 1))) {
    file.fail(label, kFocalLengthsInWords, fmt::format("{} and {}", K(0, 0), K(1, 1)));
  }
  return {K(0, 0), K(1, 1), K(0, 2), K(1, 2), 0, 0, NoDistortion{}};
}

/// P = K [I | t] places a rectified camera at X = X_reference + K^-1 (K t).
Eigen::Vector3d shift_of(const Eigen::MatrixXd& P) {
  const Eigen::Matrix3d K = P.leftCols<3>();
  return K.inverse() * P.col(3);
}

/// Two rectified cameras: P = K [I | t].
void read_rectified_pair(const LabelledNumbers& file, const std::string& left, const std::string& right,
                         RigFile& out) {
  const Eigen::MatrixXd P0 = file.matrix(left, 3, 4), P1 = file.matrix(right, 3, 4);
  StereoCalibration& calibration = out.calibration;
  calibration.cam0 = pinhole_of(file, left, P0.leftCols<3>());
  calibration.cam1 = pinhole_of(file, right, P1.leftCols<3>());
  calibration.theta << Eigen::Vector3d::Zero(), shift_of(P1) - shift_of(P0);
  calibration.body = BodyFrame::kCam0;
  out.images = ImageKind::kRectified;
  check_rig(out, file.path(), file.line(right),
            fmt::format("are {} and {} swapped?", left.substr(0, left.size() - 1),
                        right.substr(0, right.size() - 1)));
}

/// Of a file without grey cameras the colour ones are taken.
std::string left_camera(const LabelledNumbers& file, bool colour) {
  return !colour && file.has("P_rect_00:") && file.has("P_rect_01:") ? "00" : "02";
}

void read_size(const LabelledNumbers& file, const std::string& label, Camera& camera) {
  const auto size = file.numbers(label, 2);
  if (!(size[0] >= 1.0) || !(size[1] >= 1.0)) {
    file.fail(label, "a size of the images [px]", fmt::format("{} {}", size[0], size[1]));
  }
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);
}

Camera raw_camera(const LabelledNumbers& file, const std::string& number, std::vector<std::string>& notes) {
  Camera camera = pinhole_of(file, "K_" + number + ":", file.matrix("K_" + number + ":", 3, 3));
  read_size(file, "S_" + number + ":", camera);
  const std::string D = "D_" + number + ":";
  return opencv_camera(camera, file.numbers(D, 5), file.path(), file.line(D), "camera " + number, notes);
}

Eigen::Matrix3d rotation_of(const LabelledNumbers& file, const std::string& label) {
  const auto R = checked_rotation(file.matrix(label, 3, 3));
  if (!R) {
    file.fail(label, "a rotation (R^T R = I, det R = 1)", "another matrix");
  }
  return *R;
}

/// Of the reference camera: X = R X_reference + T.
Pose place_of(const LabelledNumbers& file, const std::string& number) {
  return {rotation_of(file, "R_" + number + ":"), file.matrix("T_" + number + ":", 3, 1)};
}

void read_raw_pair(const LabelledNumbers& file, const std::string& left, const std::string& right,
                   RigFile& out) {
  out.calibration.cam0 = raw_camera(file, left, out.notes);
  out.calibration.cam1 = raw_camera(file, right, out.notes);
  out.calibration.theta = rig_from_pose(place_of(file, right) * place_of(file, left).inverse());
  out.calibration.body = BodyFrame::kCam0;
  out.images = ImageKind::kRaw;
  check_rig(out, file.path(), file.line("T_" + right + ":"), "are the cameras swapped?");
}

}  // namespace

Pose kitti_colour_camera(const fs::path& path) {
  const LabelledNumbers file(path);
  return {Eigen::Matrix3d::Identity(),
          shift_of(file.matrix("P0:", 3, 4)) - shift_of(file.matrix("P2:", 3, 4))};
}

RigFile read_kitti_odometry_rig(const fs::path& path, bool colour) {
  const LabelledNumbers file(path);
  RigFile out;
  out.format = "KITTI calib.txt";
  read_rectified_pair(file, colour ? "P2:" : "P0:", colour ? "P3:" : "P1:", out);
  return out;
}

RigFile read_kitti_raw_rig(const fs::path& path, std::optional<ImageKind> images, bool colour) {
  const LabelledNumbers file(path);
  RigFile out;
  out.format = "KITTI calib_cam_to_cam.txt";
  const std::string left = left_camera(file, colour), right = left == "00" ? "01" : "03";
  if (chosen(images, path) == ImageKind::kRaw) {
    read_raw_pair(file, left, right, out);
    out.notes.push_back(fmt::format("cameras {} and {} of KITTI's rig, raw images", left, right));
    return out;
  }
  read_rectified_pair(file, "P_rect_" + left + ":", "P_rect_" + right + ":", out);
  read_size(file, "S_rect_" + left + ":", out.calibration.cam0);
  read_size(file, "S_rect_" + right + ":", out.calibration.cam1);
  out.notes.push_back(fmt::format("cameras {} and {} of KITTI's rig, rectified images", left, right));
  return out;
}

std::pair<int, int> kitti_raw_size(const fs::path& path, ImageKind images, bool colour) {
  const LabelledNumbers file(path);
  Camera camera;
  read_size(file, (images == ImageKind::kRaw ? "S_" : "S_rect_") + left_camera(file, colour) + ":", camera);
  return {camera.width, camera.height};
}

Pose kitti_camera_on_imu(const fs::path& folder, ImageKind images, bool colour) {
  const LabelledNumbers cameras(folder / "calib_cam_to_cam.txt");
  const LabelledNumbers imu(folder / "calib_imu_to_velo.txt"), velodyne(folder / "calib_velo_to_cam.txt");
  const auto pose_of = [](const LabelledNumbers& file) {
    return Pose{rotation_of(file, "R:"), file.matrix("T:", 3, 1)};
  };
  const Pose T_reference_imu = pose_of(velodyne) * pose_of(imu);
  const std::string number = left_camera(cameras, colour);
  const Pose T_cam0_reference = images == ImageKind::kRaw
                                    ? place_of(cameras, number)
                                    : Pose{rotation_of(cameras, "R_rect_00:"),
                                           shift_of(cameras.matrix("P_rect_" + number + ":", 3, 4))};
  return (T_cam0_reference * T_reference_imu).inverse();
}

}  // namespace limber::detail
