// SPDX-License-Identifier: MIT
// Kalibr's camchain.yaml and imu.yaml, and OpenVINS' flavour of both.
#include <fmt/format.h>

#include <array>
#include <utility>

#include "io/numbers.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "rig_files/camera_fit.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

constexpr double kNoCorrection = 1e-9;
constexpr const char* kKnownModels = "camera_model pinhole, omni, ds or eucm";

std::array<double, 4> four(const SensorYaml& yaml, const std::string& key) {
  const auto k = yaml.numbers(key, 4);
  return {k[0], k[1], k[2], k[3]};
}

/// The last four intrinsics of every model are fu, fv, cu, cv.
Camera pinhole_part(const SensorYaml& yaml, std::size_t before) {
  const auto values = yaml.numbers("intrinsics", before + 4);
  Camera camera{values[before], values[before + 1], values[before + 2], values[before + 3], 0, 0,
                NoDistortion{}};
  check_pinhole(yaml, "intrinsics", camera);
  read_resolution(yaml, "resolution", camera);
  return camera;
}

Camera kalibr_pinhole(const SensorYaml& yaml) {
  Camera camera = pinhole_part(yaml, 0);
  const std::string model = yaml.text("distortion_model");
  if (model == "radtan") {
    const auto k = four(yaml, "distortion_coeffs");
    camera.distortion = RadialTangential{k[0], k[1], k[2], k[3]};
  } else if (model == "equidistant") {
    const auto k = four(yaml, "distortion_coeffs");
    camera.distortion = Equidistant{k[0], k[1], k[2], k[3]};
  } else if (model != "none") {
    yaml.fail("distortion_model", "distortion_model radtan, equidistant or none of a pinhole camera",
              excerpt(model));
  }
  return camera;
}

Camera kalibr_omni(const SensorYaml& yaml) {
  const Camera camera = pinhole_part(yaml, 1);
  Omni lens{.xi = yaml.numbers("intrinsics")[0]};
  const std::string model = yaml.text("distortion_model");
  if (model == "radtan") {
    const auto k = four(yaml, "distortion_coeffs");
    lens = {lens.xi, k[0], k[1], k[2], k[3]};
  } else if (model != "none") {
    yaml.fail("distortion_model", "distortion_model radtan or none of an omni camera", excerpt(model));
  }
  return omni_camera(camera, lens, yaml, "intrinsics");
}

Camera kalibr_camera(const SensorYaml& yaml, const std::string& name, std::vector<std::string>& notes) {
  const std::string model = yaml.text("camera_model");
  if (model == "pinhole") {
    return kalibr_pinhole(yaml);
  }
  if (model == "omni") {
    return kalibr_omni(yaml);
  }
  Camera start;
  ForeignProjection projection;
  if (model == "ds") {
    start = pinhole_part(yaml, 2);
    const auto values = yaml.numbers("intrinsics");
    projection = double_sphere({start.fu, start.fv, start.cu, start.cv}, values[0], values[1]);
    start.fu /= 1.0 + values[0];
    start.fv /= 1.0 + values[0];
  } else if (model == "eucm") {
    start = pinhole_part(yaml, 2);
    const auto values = yaml.numbers("intrinsics");
    projection = extended_unified({start.fu, start.fv, start.cu, start.cv}, values[0], values[1]);
  } else {
    yaml.fail("camera_model", kKnownModels, excerpt(model));
  }
  return fitted(projection, start, yaml.path(), yaml.line("intrinsics"), name + " (" + model + ")", notes);
}

/// T_imu_cam of one camera; nothing where the chain was made without an IMU.
std::optional<Pose> imu_from_camera(const SensorYaml& yaml) {
  if (yaml.has("T_imu_cam")) {
    return yaml.transform("T_imu_cam");
  }
  return yaml.has("T_cam_imu") ? std::optional(yaml.transform("T_cam_imu").inverse()) : std::nullopt;
}

/// Of two ways to write the same: more than rounding.
bool differ(const Pose& a, const Pose& b) {
  constexpr double kFar = 5e-3, kTurned = 1e-2;  // [m], [rad]
  const Pose between = a.inverse() * b;
  return between.p.norm() > kFar || so3_log(between.R).norm() > kTurned;
}

/// Kalibr writes where cam1 stands twice: by T_cn_cnm1, and by where both cameras sit on the IMU.
void compare_places(const SensorYaml& cam0, const SensorYaml& cam1, const Pose& T_imu_cam0,
                    const Pose& T_imu_cam1, RigFile& out) {
  const Pose T_cam1_cam0 = cam1.transform("T_cn_cnm1");
  const Pose by_imu = T_imu_cam1.inverse() * T_imu_cam0;
  if (!differ(by_imu, T_cam1_cam0)) {
    return;
  }
  const bool to_imu = cam0.has("T_imu_cam");
  const char* const key = to_imu ? "T_imu_cam" : "T_cam_imu";
  if (!differ(T_imu_cam1 * T_imu_cam0.inverse(), T_cam1_cam0)) {
    cam0.fail(key, fmt::format("{} of both cameras that agrees with T_cn_cnm1 of cam1", key),
              fmt::format("their inverses, which do: rename both to {}", to_imu ? "T_cam_imu" : "T_imu_cam"));
  }
  if (!differ(by_imu.inverse(), T_cam1_cam0)) {
    cam1.fail("T_cn_cnm1",
              fmt::format("T_cn_cnm1 (it maps cam0 to cam1 coordinates) that agrees with {}", key),
              "its inverse, which does");
  }
  out.notes.push_back(
      fmt::format("T_cn_cnm1 of cam1 and {} of both cameras contradict each other, by {:.1f} mm and {:.2f} "
                  "deg: T_cn_cnm1 "
                  "and cam0's count",
                  key, 1e3 * (by_imu.p - T_cam1_cam0.p).norm(),
                  so3_log(Eigen::Matrix3d(by_imu.R.transpose() * T_cam1_cam0.R)).norm() * kToDegrees));
}

/// What to ask where cam1 is not to the right of cam0.
std::string doubts(const StereoCalibration& calibration, bool by_imu) {
  std::string exchanged;
  if (by_imu) {
    const Pose T_imu_cam0 = calibration.T_body_cam0;
    const Pose T_imu_cam1 = T_imu_cam0 * pose_from_rig(calibration.theta).inverse();
    const Eigen::Vector3d t = (T_imu_cam1 * T_imu_cam0.inverse()).p;
    exchanged = fmt::format(" (the other way round they say {:.3f}, {:.3f}, {:.3f} m)", t.x(), t.y(), t.z());
  }
  return "are the cameras swapped, or T_cam_imu and T_imu_cam" + exchanged +
         ", or is T_cn_cnm1 inverted (it maps cam0 to cam1 coordinates)?";
}

void place_cameras(const SensorYaml& cam0, const SensorYaml& cam1, RigFile& out) {
  const auto T_imu_cam0 = imu_from_camera(cam0);
  if (cam1.has("T_cn_cnm1")) {
    const Pose T_cam1_cam0 = cam1.transform("T_cn_cnm1");
    out.calibration.body = BodyFrame::kCam0;
    out.calibration.theta = rig_from_pose(T_cam1_cam0);
    if (T_imu_cam0) {
      place_on_imu(out.calibration, *T_imu_cam0, *T_imu_cam0 * T_cam1_cam0.inverse());
      if (const auto T_imu_cam1 = imu_from_camera(cam1)) {
        compare_places(cam0, cam1, *T_imu_cam0, *T_imu_cam1, out);
      }
    }
    return;
  }
  const auto T_imu_cam1 = imu_from_camera(cam1);
  if (!T_imu_cam0 || !T_imu_cam1) {
    throw DataError(cam1.path().string(), 0, "T_cn_cnm1 of cam1, or T_cam_imu of both cameras", "neither");
  }
  place_on_imu(out.calibration, *T_imu_cam0, *T_imu_cam1);
}

void require_identity(const SensorYaml& yaml, const char* key, Eigen::Index size, bool zero) {
  if (!yaml.has(key)) {
    return;
  }
  const Eigen::MatrixXd found = yaml.matrix(key, size, size);
  const Eigen::MatrixXd wanted =
      zero ? Eigen::MatrixXd::Zero(size, size) : Eigen::MatrixXd(Eigen::MatrixXd::Identity(size, size));
  if ((found - wanted).cwiseAbs().maxCoeff() > kNoCorrection) {
    yaml.fail(
        key,
        fmt::format("{} that is {}: samples must be corrected already", key, zero ? "zero" : "the identity"),
        "another matrix");
  }
}

}  // namespace

RigFile read_kalibr_rig(const SensorYaml& yaml) {
  const SensorYaml cam0 = yaml.section("cam0"), cam1 = yaml.section("cam1");
  RigFile out;
  out.format = "Kalibr camchain";
  out.calibration.cam0 = kalibr_camera(cam0, "cam0", out.notes);
  out.calibration.cam1 = kalibr_camera(cam1, "cam1", out.notes);
  place_cameras(cam0, cam1, out);
  std::size_t camera = 0;
  for (const SensorYaml* cam : {&cam0, &cam1}) {
    if (cam->has("timeshift_cam_imu")) {  // t_imu = t_cam + shift
      out.calibration.time_offset_s[camera] = cam->number("timeshift_cam_imu");
    }
    const Camera& model = camera == 0 ? out.calibration.cam0 : out.calibration.cam1;
    for (const auto& [key, unit] : {std::pair{"line_delay", 1.0}, {"line_delay_nanoseconds", 1e-9}}) {
      if (cam->has(key)) {
        out.calibration.readout_time_s[camera] = checked_readout(*cam, key, unit * model.height);
      }
    }
    ++camera;
  }
  check_rig(out, yaml.path(), yaml.line("cam1"), doubts(out.calibration, !cam1.has("T_cn_cnm1")));
  return out;
}

}  // namespace limber::detail

namespace limber {

ImuNoise read_kalibr_imu(const std::filesystem::path& path) {
  const detail::SensorYaml file(path);
  if (file.has("cam0")) {
    throw DataError(path.string(), 0, "the noise of an IMU (gyroscope_noise_density, ...)",
                    "a calibration of cameras, which --calib takes");
  }
  const detail::SensorYaml yaml = file.has("imu0") ? file.section("imu0") : file;
  detail::require_identity(yaml, "T_i_b", 4, false);
  for (const char* key : {"Tw", "Ta", "R_IMUtoGYRO", "R_IMUtoACC"}) {
    detail::require_identity(yaml, key, 3, false);
  }
  detail::require_identity(yaml, "Tg", 3, true);
  if (yaml.has("time_offset") && yaml.number("time_offset") != 0.0) {
    yaml.fail("time_offset", "time_offset 0: stamps must be corrected already", yaml.text("time_offset"));
  }
  return detail::read_imu_noise(yaml);
}

}  // namespace limber
