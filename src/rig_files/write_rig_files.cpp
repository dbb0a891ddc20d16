// SPDX-License-Identifier: MIT
#include "limber/rig_files/write_rig_files.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "limber/io/atomic_file.hpp"
#include "rig_files/euroc_text.hpp"
#include "rig_files/opencv_lens.hpp"
#include "rig_files/rectified_pair.hpp"

namespace limber {
namespace detail {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct DistortionText {
  std::string model, coefficients;
};

DistortionText distortion_text(const Distortion& distortion) {
  const auto k = opencv_coefficients(distortion);
  if (std::holds_alternative<NoDistortion>(distortion)) {
    return {"none", "[]"};
  }
  return k ? DistortionText{"radial-tangential", list_of(*k)}
           : DistortionText{std::string(model_name(distortion)), list_of(coefficients(distortion))};
}

/// The camera model, its intrinsics and the lens on the plane that it projects to, as Kalibr says them.
struct CameraText {
  std::string model;
  std::vector<double> intrinsics;
  Distortion distortion;
};

CameraText camera_text(const Camera& camera) {
  const auto* omni = std::get_if<Omni>(&camera.distortion);
  if (omni == nullptr) {
    return {"pinhole", {camera.fu, camera.fv, camera.cu, camera.cv}, camera.distortion};
  }
  const double scale = 1.0 + omni->xi;
  const RadialTangential plane{omni->k1, omni->k2, omni->p1, omni->p2};
  const bool plain = coefficients(plane) == std::vector<double>(4, 0.0);
  return {"omni",
          {omni->xi, scale * camera.fu, scale * camera.fv, camera.cu, camera.cv},
          plain ? Distortion(NoDistortion{}) : Distortion(plane)};
}

void require_rigid_body(const StereoCalibration& calibration) {
  if (calibration.body == BodyFrame::kMiddleOfBaseline) {
    throw std::invalid_argument("calibration files: the body kMiddleOfBaseline moves with theta");
  }
}

Pose body_from_camera(const StereoCalibration& calibration, int camera) {
  require_rigid_body(calibration);
  const Pose T_body_cam0 = calibration.body == BodyFrame::kCam0 ? Pose{} : calibration.T_body_cam0;
  return camera == 0 ? T_body_cam0 : T_body_cam0 * pose_from_rig(calibration.theta).inverse();
}

double readout_of(const StereoCalibration& calibration, int camera) {
  return calibration.readout_time_s.at(static_cast<std::size_t>(camera));
}

RowMajor matrix_of(const Pose& pose) {
  RowMajor T = RowMajor::Identity(4, 4);
  T.topLeftCorner(3, 3) = pose.R;
  T.topRightCorner(3, 1) = pose.p;
  return T;
}

/// Rows as Kalibr writes them.
std::string rows_text(const RowMajor& M) {
  std::string out;
  for (Eigen::Index k = 0; k < M.rows(); ++k) {
    out += fmt::format("  - {}\n", list_of(M.row(k).data(), static_cast<std::size_t>(M.cols())));
  }
  return out;
}

bool kalibr_knows(const StereoCalibration& calibration) {
  return !std::holds_alternative<Rational>(calibration.cam0.distortion) &&
         !std::holds_alternative<Rational>(calibration.cam1.distortion);
}

std::string kalibr_camera(const StereoCalibration& calibration, int camera) {
  const Camera& cam = camera == 0 ? calibration.cam0 : calibration.cam1;
  const CameraText text = camera_text(cam);
  std::string out =
      fmt::format("cam{}:\n  cam_overlaps: [{}]\n  camera_model: {}\n", camera, 1 - camera, text.model);
  if (calibration.body == BodyFrame::kImu) {
    out += "  T_cam_imu:\n" + rows_text(matrix_of(body_from_camera(calibration, camera).inverse()));
    out += fmt::format("  timeshift_cam_imu: {}\n",
                       calibration.time_offset_s.at(static_cast<std::size_t>(camera)));
  }
  if (const double readout = readout_of(calibration, camera); readout != 0.0) {
    out += fmt::format("  line_delay: {}\n", readout / cam.height);
  }
  if (camera == 1) {
    out += "  T_cn_cnm1:\n" + rows_text(matrix_of(pose_from_rig(calibration.theta)));
  }
  const auto radtan = opencv_coefficients(text.distortion);
  return out +
         fmt::format(
             "  intrinsics: {}\n  distortion_model: {}\n  distortion_coeffs: {}\n  resolution: [{}, {}]\n"
             "  rostopic: /cam{}/image_raw\n",
             list_of(text.intrinsics), radtan ? "radtan" : "equidistant",
             list_of(radtan.value_or(coefficients(text.distortion))), cam.width, cam.height, camera);
}

RowMajor camera_matrix(const Camera& camera) {
  RowMajor K = RowMajor::Identity(3, 3);
  K(0, 0) = camera.fu;
  K(1, 1) = camera.fv;
  K(0, 2) = camera.cu;
  K(1, 2) = camera.cv;
  return K;
}

std::string opencv_matrix(const char* name, const RowMajor& M) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: {}\n", name, M.rows(),
                     M.cols(), list_of(M.data(), static_cast<std::size_t>(M.size())));
}

bool is_equidistant(const StereoCalibration& calibration) {
  return std::holds_alternative<Equidistant>(calibration.cam0.distortion) &&
         std::holds_alternative<Equidistant>(calibration.cam1.distortion);
}

bool opencv_knows(const StereoCalibration& calibration) {
  return is_equidistant(calibration) || (opencv_coefficients(calibration.cam0.distortion) &&
                                         opencv_coefficients(calibration.cam1.distortion));
}

/// What cv::FileStorage is to hold of a calibration that opencv_knows.
const char* opencv_model(const StereoCalibration& calibration) {
  constexpr std::size_t kPlumbBob = 5;
  const auto is_rational = [](const Camera& camera) {
    return opencv_coefficients(camera.distortion)->size() > kPlumbBob;
  };
  return is_equidistant(calibration)                                      ? "equidistant"
         : is_rational(calibration.cam0) || is_rational(calibration.cam1) ? "rational_polynomial"
                                                                          : "plumb_bob";
}

RowMajor opencv_distortion(const Camera& camera) {
  const auto k = opencv_coefficients(camera.distortion).value_or(coefficients(camera.distortion));
  return Eigen::Map<const RowMajor>(k.data(), 1, std::ssize(k));
}

RowMajor disparity_to_depth(const RectifiedPair& pair) {
  RowMajor Q = RowMajor::Zero(4, 4);
  Q << 1, 0, 0, -pair.cu, 0, 1, 0, -pair.cv, 0, 0, 0, pair.f, 0, 0, 1.0 / pair.baseline, 0;
  return Q;
}

/// k1 k2 p1 p2 k3
constexpr std::size_t kKittiCoefficients = 5;

bool kitti_knows(const Camera& camera) {
  const auto k = opencv_coefficients(camera.distortion);
  return k && k->size() <= kKittiCoefficients;
}

std::string kitti_line(const std::string& label, const RowMajor& M) {
  return fmt::format("{}: {}\n", label, fmt::join(M.data(), M.data() + M.size(), " "));
}

std::string kitti_camera(const Camera& camera, const std::string& number, const Pose& T_cam_cam0,
                         const Eigen::Matrix3d& R_rect, const RowMajor& P_rect) {
  auto k = *opencv_coefficients(camera.distortion);
  k.resize(kKittiCoefficients);
  const RowMajor D = Eigen::Map<const RowMajor>(k.data(), 1, std::ssize(k));
  const RowMajor size = Eigen::RowVector2d(camera.width, camera.height);
  return kitti_line("S_" + number, size) + kitti_line("K_" + number, camera_matrix(camera)) +
         kitti_line("D_" + number, D) + kitti_line("R_" + number, T_cam_cam0.R) +
         kitti_line("T_" + number, T_cam_cam0.p) + kitti_line("S_rect_" + number, size) +
         kitti_line("R_rect_" + number, R_rect) + kitti_line("P_rect_" + number, P_rect);
}

/// Of the camera that a format has no word for.
std::string lens_in_words(const StereoCalibration& calibration) {
  const auto first = model_name(calibration.cam0.distortion),
             second = model_name(calibration.cam1.distortion);
  return first == second ? std::string(first) : fmt::format("{} and {}", first, second);
}

/// What a format has no word for; empty if there is no such thing.
std::string unknown_lens(bool known, const StereoCalibration& calibration) {
  return known ? "" : lens_in_words(calibration) + " distortion";
}

std::string unknown_to_opencv(const StereoCalibration& calibration) {
  const Camera &cam0 = calibration.cam0, &cam1 = calibration.cam1;
  const bool same_size = cam0.width == cam1.width && cam0.height == cam1.height;
  return same_size ? unknown_lens(opencv_knows(calibration), calibration) : "images of two sizes";
}

void require_none(const std::string& unknown, const char* format) {
  if (!unknown.empty()) {
    throw std::invalid_argument(fmt::format("{} cannot say {}", format, unknown));
  }
}

constexpr const char *kKalibrFile = "camchain.yaml", *kOpenCvFile = "stereo.yml",
                     *kKittiFile = "calib_cam_to_cam.txt";

std::string unknown_to_kalibr(const StereoCalibration& calibration) {
  return unknown_lens(kalibr_knows(calibration), calibration);
}

std::string unknown_to_kitti(const StereoCalibration& calibration) {
  return unknown_lens(kitti_knows(calibration.cam0) && kitti_knows(calibration.cam1), calibration);
}

/// A file that knows some rigs only.
struct ForeignFile {
  const char* name;
  std::string unknown;
  std::string (*text)(const StereoCalibration&);
};

std::array<ForeignFile, 3> foreign_files(const StereoCalibration& calibration) {
  return {{{kKalibrFile, unknown_to_kalibr(calibration), kalibr_camchain},
           {kOpenCvFile, unknown_to_opencv(calibration), opencv_stereo_yaml},
           {kKittiFile, unknown_to_kitti(calibration), kitti_cam_to_cam}}};
}

}  // namespace

std::string list_of(const double* begin, std::size_t count) {
  if (std::any_of(begin, begin + count, [](double value) { return !std::isfinite(value); })) {
    throw std::invalid_argument("calibration files: a number is not finite");
  }
  return fmt::format("[{}]", fmt::join(begin, begin + count, ", "));
}

std::string list_of(const std::vector<double>& values) { return list_of(values.data(), values.size()); }

std::string T_BS_text(const Pose& T_body_sensor) {
  return fmt::format("T_BS:\n  cols: 4\n  rows: 4\n  data: {}\n",
                     list_of(matrix_of(T_body_sensor).data(), 16));
}

std::string camera_yaml(const Camera& camera, const Pose& T_body_cam) {
  const CameraText text = camera_text(camera);
  const DistortionText distortion = distortion_text(text.distortion);
  return fmt::format(
      "sensor_type: camera\n{}resolution: [{}, {}]\ncamera_model: {}\n"
      "intrinsics: {}  # {}{}distortion_model: {}\ndistortion_coefficients: {}\n",
      T_BS_text(T_body_cam), camera.width, camera.height, text.model, list_of(text.intrinsics),
      text.model == "omni" ? "xi, " : "", kIntrinsicsMark, distortion.model, distortion.coefficients);
}

}  // namespace detail

using namespace detail;

std::string euroc_sensor_yaml(const StereoCalibration& calibration, int camera) {
  const double readout = readout_of(calibration, camera);
  return camera_yaml(camera == 0 ? calibration.cam0 : calibration.cam1,
                     body_from_camera(calibration, camera)) +
         (readout == 0.0 ? ""
                         : fmt::format("readout_time: {}  # from the first row to the last [s]\n", readout));
}

std::string kalibr_camchain(const StereoCalibration& calibration) {
  require_rigid_body(calibration);
  require_none(unknown_to_kalibr(calibration), kKalibrFile);
  return kalibr_camera(calibration, 0) + kalibr_camera(calibration, 1);
}

std::string kalibr_imu(const ImuNoise& noise) {
  return fmt::format(
      "accelerometer_noise_density: {}  # [m/s^2/sqrt(Hz)]\naccelerometer_random_walk: {}  # "
      "[m/s^3/sqrt(Hz)]\n"
      "gyroscope_noise_density: {}  # [rad/s/sqrt(Hz)]\ngyroscope_random_walk: {}  # [rad/s^2/sqrt(Hz)]\n"
      "rostopic: /imu0\n",
      noise.accel_density, noise.accel_walk, noise.gyro_density, noise.gyro_walk);
}

std::string opencv_stereo_yaml(const StereoCalibration& calibration) {
  require_rigid_body(calibration);
  require_none(unknown_to_opencv(calibration), kOpenCvFile);
  const Camera &cam0 = calibration.cam0, &cam1 = calibration.cam1;
  const Pose T_cam1_cam0 = pose_from_rig(calibration.theta);
  const RectifiedPair pair = rectify(calibration);
  return fmt::format("%YAML:1.0\n---\nsize: [ {}, {} ]\ndistortion_model: {}\n", cam0.width, cam0.height,
                     opencv_model(calibration)) +
         opencv_matrix("M1", camera_matrix(cam0)) + opencv_matrix("D1", opencv_distortion(cam0)) +
         opencv_matrix("M2", camera_matrix(cam1)) + opencv_matrix("D2", opencv_distortion(cam1)) +
         opencv_matrix("R", T_cam1_cam0.R) + opencv_matrix("T", T_cam1_cam0.p) +
         opencv_matrix("R1", pair.R0) + opencv_matrix("R2", pair.R1) + opencv_matrix("P1", pair.P0()) +
         opencv_matrix("P2", pair.P1()) + opencv_matrix("Q", disparity_to_depth(pair));
}

std::string kitti_calib(const StereoCalibration& calibration) {
  require_rigid_body(calibration);
  const RectifiedPair pair = rectify(calibration);
  return kitti_line("P0", pair.P0()) + kitti_line("P1", pair.P1());
}

std::string kitti_cam_to_cam(const StereoCalibration& calibration) {
  require_rigid_body(calibration);
  require_none(unknown_to_kitti(calibration), kKittiFile);
  const RectifiedPair pair = rectify(calibration);
  return kitti_camera(calibration.cam0, "00", Pose{}, pair.R0, pair.P0()) +
         kitti_camera(calibration.cam1, "01", pose_from_rig(calibration.theta), pair.R1, pair.P1());
}

std::vector<std::string> rig_file_names() {
  return {"cam0/sensor.yaml", "cam1/sensor.yaml", "camchain.yaml",       "imu.yaml",
          "stereo.yml",       "calib.txt",        "calib_cam_to_cam.txt"};
}

std::vector<std::string> rig_files_left_out(const StereoCalibration& calibration) {
  std::vector<std::string> out;
  for (const ForeignFile& file : foreign_files(calibration)) {
    if (!file.unknown.empty()) {
      out.push_back(fmt::format("{} is not written: it cannot say {}", file.name, file.unknown));
    }
  }
  return out;
}

std::vector<std::string> write_rig_files(const std::filesystem::path& folder,
                                         const StereoCalibration& calibration,
                                         const std::optional<ImuNoise>& noise) {
  std::vector<std::pair<std::string, std::string>> files = {
      {"cam0/sensor.yaml", euroc_sensor_yaml(calibration, 0)},
      {"cam1/sensor.yaml", euroc_sensor_yaml(calibration, 1)},
      {"calib.txt", kitti_calib(calibration)}};
  for (const ForeignFile& file : foreign_files(calibration)) {
    if (file.unknown.empty()) {
      files.emplace_back(file.name, file.text(calibration));
    }
  }
  if (noise) {
    files.emplace_back("imu.yaml", kalibr_imu(*noise));
  }
  std::vector<std::string> names;
  for (const auto& [name, content] : files) {
    std::filesystem::create_directories((folder / name).parent_path());
    write_file_atomically(folder / name, content);
    names.push_back(name);
  }
  return names;
}

}  // namespace limber
