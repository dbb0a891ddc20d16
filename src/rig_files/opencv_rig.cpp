// SPDX-License-Identifier: MIT
// What cv::stereoCalibrate and cv::stereoRectify return, as cv::FileStorage writes it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>

#include "io/numbers.hpp"
#include "limber/core/errors.hpp"
#include "rig_files/opencv_lens.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

/// [m]: beyond, T is in the unit of the chessboard.
constexpr double kLongestBaseline = 10.0;

using Names = std::initializer_list<const char*>;

/// The name that the file uses; nothing if it has none of them.
std::optional<std::string> name_in(const SensorYaml& yaml, Names names) {
  const auto* const found =
      std::find_if(names.begin(), names.end(), [&](const char* key) { return yaml.has(key); });
  return found == names.end() ? std::nullopt : std::optional<std::string>(*found);
}

std::string required_name(const SensorYaml& yaml, Names names) {
  if (const auto name = name_in(yaml, names)) {
    return *name;
  }
  std::string all;
  for (const char* name : names) {
    all += (all.empty() ? "" : " or ") + std::string(name);
  }
  throw DataError(yaml.path().string(), 0, "the key " + all, "no such key");
}

void read_size(const SensorYaml& yaml, Camera& camera) {
  if (const auto key = name_in(yaml, {"size", "image_size", "imageSize", "img_size", "resolution"})) {
    read_resolution(yaml, *key, camera);
  } else if (yaml.has("image_width") && yaml.has("image_height")) {
    camera.width = static_cast<int>(yaml.not_negative("image_width"));
    camera.height = static_cast<int>(yaml.not_negative("image_height"));
  }
}

Camera pinhole_of(const SensorYaml& yaml, const std::string& key, const Eigen::MatrixXd& K) {
  if (K(0, 1) != 0.0 || K(1, 0) != 0.0 || K(2, 0) != 0.0 || K(2, 1) != 0.0 || K(2, 2) != 1.0) {
    yaml.fail(key, key + " as (fu 0 cu, 0 fv cv, 0 0 1)", "another matrix");
  }
  Camera camera{K(0, 0), K(1, 1), K(0, 2), K(1, 2), 0, 0, NoDistortion{}};
  check_pinhole(yaml, key, camera);
  read_size(yaml, camera);
  return camera;
}

bool is_fisheye(const SensorYaml& yaml) {
  const auto key = name_in(yaml, {"distortion_model", "camera_model", "model"});
  const std::string model = key ? yaml.text(*key) : "plumb_bob";
  if (model == "equidistant" || model == "fisheye") {
    return true;
  }
  constexpr std::array kPinhole = {"plumb_bob", "radtan", "radial-tangential", "rational_polynomial",
                                   "pinhole"};
  if (std::find(kPinhole.begin(), kPinhole.end(), model) == kPinhole.end()) {
    yaml.fail(*key, "plumb_bob, radtan, rational_polynomial, pinhole, equidistant or fisheye",
              excerpt(model));
  }
  return false;
}

Camera raw_camera(const SensorYaml& yaml, const std::string& M, const std::string& D, const std::string& name,
                  std::vector<std::string>& notes) {
  Camera camera = pinhole_of(yaml, M, yaml.matrix(M, 3, 3));
  const auto k = yaml.entries(D);
  if (is_fisheye(yaml)) {
    if (k.size() != 4) {
      yaml.fail(D, D + " as four coefficients of a fisheye camera", fmt::format("{} numbers", k.size()));
    }
    camera.distortion = Equidistant{k[0], k[1], k[2], k[3]};
    return camera;
  }
  if (k.size() == 4 && !name_in(yaml, {"distortion_model", "camera_model", "model"})) {
    notes.push_back(name +
                    ": four distortion coefficients are taken for k1 k2 p1 p2; of cv::fisheye, say "
                    "distortion_model: equidistant in the file");
  }
  return opencv_camera(camera, k, yaml.path(), yaml.line(D), name, notes);
}

void require_metres(const SensorYaml& yaml, const std::string& key, double baseline) {
  if (baseline > kLongestBaseline) {
    yaml.fail(key, fmt::format("a baseline in metres, at most {}", kLongestBaseline),
              fmt::format("{:.4g}: in millimetres, as the chessboard was given?", baseline));
  }
}

void read_raw(const SensorYaml& yaml, RigFile& out) {
  StereoCalibration& calibration = out.calibration;
  calibration.cam0 = raw_camera(yaml, required_name(yaml, {"M1", "K1", "cameraMatrix1"}),
                                required_name(yaml, {"D1", "distCoeffs1"}), "camera 1", out.notes);
  calibration.cam1 = raw_camera(yaml, required_name(yaml, {"M2", "K2", "cameraMatrix2"}),
                                required_name(yaml, {"D2", "distCoeffs2"}), "camera 2", out.notes);
  const std::string R = required_name(yaml, {"R"}), T = required_name(yaml, {"T"});
  const auto rotation = checked_rotation(yaml.matrix(R, 3, 3));
  if (!rotation) {
    yaml.fail(R, "a rotation (R^T R = I, det R = 1)", "another matrix");
  }
  calibration.theta = rig_from_pose({*rotation, yaml.matrix(T, 3, 1)});
  require_metres(yaml, T, calibration.baseline());
  check_rig(out, yaml.path(), yaml.line(T),
            "are the cameras swapped, or is (R, T) inverted (it maps camera 1 to "
            "camera 2 coordinates)?");
}

void read_rectified(const SensorYaml& yaml, RigFile& out) {
  const Eigen::MatrixXd P1 = yaml.matrix("P1", 3, 4), P2 = yaml.matrix("P2", 3, 4);
  StereoCalibration& calibration = out.calibration;
  calibration.cam0 = pinhole_of(yaml, "P1", P1.leftCols(3));
  calibration.cam1 = pinhole_of(yaml, "P2", P2.leftCols(3));
  calibration.theta << Eigen::Vector3d::Zero(), P2(0, 3) / P2(0, 0), P2(1, 3) / P2(1, 1), 0.0;
  require_metres(yaml, "P2", calibration.baseline());
  check_rig(out, yaml.path(), yaml.line("P2"), "are P1 and P2 swapped?");
}

}  // namespace

Camera opencv_camera(Camera pinhole, const std::vector<double>& coefficients,
                     const std::filesystem::path& place, std::size_t line, const std::string& name,
                     std::vector<std::string>& notes) {
  constexpr std::array<std::size_t, 5> kCounts = {4, 5, 8, 12, 14};
  if (std::find(kCounts.begin(), kCounts.end(), coefficients.size()) == kCounts.end()) {
    throw DataError(place.string(), line, "4, 5, 8, 12 or 14 distortion coefficients",
                    fmt::format("{}", coefficients.size()));
  }
  if (coefficients.size() == 14 && (coefficients[12] != 0.0 || coefficients[13] != 0.0)) {
    throw DataError(place.string(), line, "a sensor that is not tilted (the last two coefficients zero)",
                    "a tilt");
  }
  constexpr std::ptrdiff_t kWithoutPrism = 8;
  std::array<double, 12> k{};
  std::copy_n(coefficients.begin(), std::min(coefficients.size(), k.size()), k.begin());
  pinhole.distortion = opencv_lens({k.begin(), k.begin() + kWithoutPrism});
  if (std::all_of(k.begin() + kWithoutPrism, k.end(), [](double value) { return value == 0.0; })) {
    return pinhole;
  }
  return fitted(opencv_pinhole({pinhole.fu, pinhole.fv, pinhole.cu, pinhole.cv}, k), pinhole, place, line,
                fmt::format("{} ({} distortion coefficients)", name, coefficients.size()), notes);
}

RigFile read_opencv_rig(const SensorYaml& yaml, std::optional<ImageKind> images) {
  const bool raw = name_in(yaml, {"M1", "K1", "cameraMatrix1"}) && yaml.has("R");
  const bool rectified = yaml.has("P1") && yaml.has("P2");
  if (!raw && !rectified) {
    throw DataError(
        yaml.path().string(), 0,
        "M1 D1 M2 D2 R T (raw images) or P1 P2 (rectified ones) in one file; OpenCV's sample writes "
        "intrinsics.yml and extrinsics.yml, which belong together",
        "neither");
  }
  RigFile out;
  out.format = "OpenCV stereo YAML";
  out.calibration.body = BodyFrame::kCam0;
  out.images = raw && rectified ? chosen(images, yaml.path()) : raw ? ImageKind::kRaw : ImageKind::kRectified;
  if (raw && rectified) {
    out.notes.push_back("of both that the file holds, its calibration of " + to_string(out.images) +
                        " images");
  }
  out.images == ImageKind::kRaw ? read_raw(yaml, out) : read_rectified(yaml, out);
  return out;
}

}  // namespace limber::detail
