// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "io/text_file.hpp"
#include "limber/core/errors.hpp"
#include "rig_files/camera_fit.hpp"
#include "rig_files/check_baseline.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber {
namespace detail {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKnownRigs =
    "a stereo calibration: a Kalibr camchain (cam0:, cam1:), OpenCV's M1 D1 M2 D2 R T or P1 P2, Basalt's "
    "JSON "
    "(value0), KITTI's calib.txt (P0:, P1:) or calib_cam_to_cam.txt (K_00:, P_rect_00:), or a folder with "
    "cam0/sensor.yaml and cam1/sensor.yaml";

/// Whether a line of the text begins with `label`.
bool has_label(std::string_view text, std::string_view label) {
  return text.starts_with(label) || text.find(fmt::format("\n{}", label)) != std::string_view::npos;
}

RigFile read_folder(const fs::path& folder) {
  for (const fs::path& base : {folder, folder / "mav0"}) {
    if (fs::exists(base / "cam0" / "sensor.yaml")) {
      return read_euroc_rig(base);
    }
  }
  if (fs::exists(folder / "sensor_cam0.yaml")) {
    return read_cuvslam_rig(folder);
  }
  throw DataError(folder.string(), 0, "cam0/sensor.yaml and cam1/sensor.yaml (also below mav0)",
                  "none of these in the folder");
}

RigFile read_file(const fs::path& path, std::optional<ImageKind> images) {
  const std::string text = load_text(path);
  if (text.starts_with("<?xml")) {
    throw DataError(path.string(), 0, "OpenCV's YAML or JSON",
                    "XML: cv::FileStorage writes YAML to a name that "
                    "ends in .yml");
  }
  if (has_label(text, "P_rect_0")) {
    return read_kitti_raw_rig(path, images);
  }
  if (has_label(text, "P0:")) {
    return read_kitti_odometry_rig(path);
  }
  const SensorYaml yaml(path);
  if (yaml.has("value0")) {
    return read_basalt_rig(yaml.section("value0"));
  }
  if (yaml.has("cam0") && yaml.has("cam1")) {
    return read_kalibr_rig(yaml);
  }
  if (yaml.has("cam0")) {
    throw DataError(path.string(), 0, "cam0 and cam1: two cameras", "cam0 alone");
  }
  if (yaml.has("imu0") || yaml.has("gyroscope_noise_density")) {
    throw DataError(path.string(), 0, kKnownRigs, "the noise of an IMU, which --imu takes");
  }
  if (yaml.has("T_BS")) {
    throw DataError(path.string(), 0, "the folder that holds cam0/sensor.yaml and cam1/sensor.yaml",
                    "the sensor.yaml of one sensor");
  }
  constexpr std::array kOpenCv = {"M1", "K1", "cameraMatrix1", "P1", "R", "M2", "P2"};
  if (std::any_of(kOpenCv.begin(), kOpenCv.end(), [&](const char* key) { return yaml.has(key); })) {
    return read_opencv_rig(yaml, images);
  }
  throw DataError(path.string(), 0, kKnownRigs, "none of these");
}

void drop_zero_distortion(Camera& camera) {
  const auto* d = std::get_if<RadialTangential>(&camera.distortion);
  if (d != nullptr && d->k1 == 0.0 && d->k2 == 0.0 && d->p1 == 0.0 && d->p2 == 0.0) {
    camera.distortion = NoDistortion{};
  }
}

}  // namespace

void place_on_imu(StereoCalibration& calibration, const Pose& T_imu_cam0, const Pose& T_imu_cam1) {
  calibration.body = BodyFrame::kImu;
  calibration.T_body_cam0 = T_imu_cam0;
  calibration.theta = rig_from_pose(T_imu_cam1.inverse() * T_imu_cam0);
}

void check_rig(RigFile& rig, const fs::path& file, std::size_t line, const std::string& hint) {
  const std::string note = check_baseline(rig.calibration.theta, file, line, hint);
  if (!note.empty()) {
    rig.notes.push_back(note);
  }
}

ImageKind chosen(std::optional<ImageKind> images, const fs::path& file) {
  if (!images) {
    throw DataError(file.string(), 0, "to be told which images there are, raw or rectified",
                    "calibrations of both in the file, and no choice");
  }
  return *images;
}

Camera omni_camera(Camera pinhole, const Omni& lens, const SensorYaml& yaml, const std::string& key) {
  if (!(lens.xi > -1.0)) {
    yaml.fail(key, "xi above -1 of an omni camera", fmt::format("{}", lens.xi));
  }
  pinhole.fu /= 1.0 + lens.xi;
  pinhole.fv /= 1.0 + lens.xi;
  check_pinhole(yaml, key, pinhole);
  pinhole.distortion = lens;
  return pinhole;
}

Camera fitted(const ForeignProjection& projection, const Camera& start, const fs::path& place,
              std::size_t line, const std::string& name, std::vector<std::string>& notes) {
  if (start.width == 0) {
    throw DataError(place.string(), line, "the size of the images beside a camera model that limber has not",
                    "none");
  }
  const auto fit = fit_camera(projection, start);
  if (!fit || fit->worst_px > kWorstFit_px) {
    throw DataError(
        place.string(), line,
        fmt::format(
            "a camera model of limber's, or one that pinhole with radial-tangential (k1, k2, p1, p2) or "
            "equidistant distortion can stand for to {} px",
            kWorstFit_px),
        (fit ? fmt::format("{}: {:.2g} px off at worst", name, fit->worst_px) : name + ": nothing fits") +
            "; Kalibr's --models pinhole-radtan, pinhole-equi and omni-radtan give such models, and "
            "rectified "
            "images need none");
  }
  notes.push_back(fmt::format(
      "{}: taken as pinhole with {} distortion, the same to {:.2g} px anywhere in the image", name,
      std::holds_alternative<Equidistant>(fit->camera.distortion) ? "equidistant" : "radial-tangential",
      fit->worst_px));
  return fit->camera;
}

}  // namespace detail

std::string to_string(ImageKind kind) { return kind == ImageKind::kRaw ? "raw" : "rectified"; }

RigFile read_rig_file(const std::filesystem::path& path, std::optional<ImageKind> images) {
  namespace fs = std::filesystem;
  RigFile out;
  try {
    out = fs::is_directory(path) ? detail::read_folder(path) : detail::read_file(path, images);
  } catch (const fs::filesystem_error& e) {
    throw DataError(path.string(), 0, "a readable file or folder", e.code().message());
  }
  detail::drop_zero_distortion(out.calibration.cam0);
  detail::drop_zero_distortion(out.calibration.cam1);
  return out;
}

}  // namespace limber
