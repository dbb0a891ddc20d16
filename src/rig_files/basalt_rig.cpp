// SPDX-License-Identifier: MIT
// Basalt's calibration.json. JSON is YAML, which keeps the line numbers.
#include <fmt/format.h>

#include <algorithm>

#include "io/numbers.hpp"
#include "rig_files/camera_fit.hpp"
#include "rig_files/rig_formats.hpp"

namespace limber::detail {
namespace {

constexpr double kNanosecond = 1e-9;

Pose basalt_pose(const SensorYaml& yaml) {
  const auto R =
      checked_quaternion({yaml.number("qw"), yaml.number("qx"), yaml.number("qy"), yaml.number("qz")});
  if (!R) {
    yaml.fail("qw", "a quaternion of unit norm", "another");
  }
  return {*R, {yaml.number("px"), yaml.number("py"), yaml.number("pz")}};
}

Camera basalt_pinhole(const SensorYaml& yaml, const Camera& size) {
  Camera camera = size;
  camera.fu = yaml.number("fx");
  camera.fv = yaml.number("fy");
  camera.cu = yaml.number("cx");
  camera.cv = yaml.number("cy");
  check_pinhole(yaml, "fx", camera);
  return camera;
}

/// alpha = xi / (1 + xi), with the focal lengths of the axis.
Camera unified_camera(Camera camera, const SensorYaml& yaml) {
  const double alpha = yaml.number("alpha");
  if (!(alpha >= 0.0 && alpha < 1.0)) {
    yaml.fail("alpha", "alpha from 0 to below 1", fmt::format("{}", alpha));
  }
  camera.distortion = Omni{.xi = alpha / (1.0 - alpha)};
  return camera;
}

Camera basalt_camera(const SensorYaml& entry, const Camera& size, const std::string& name,
                     std::vector<std::string>& notes) {
  const std::string type = entry.text("camera_type");
  const SensorYaml yaml = entry.section("intrinsics");
  Camera camera = basalt_pinhole(yaml, size);
  const Pinhole pinhole{camera.fu, camera.fv, camera.cu, camera.cv};
  ForeignProjection projection;
  if (type == "pinhole") {
    return camera;
  }
  if (type == "kb4") {
    camera.distortion =
        Equidistant{yaml.number("k1"), yaml.number("k2"), yaml.number("k3"), yaml.number("k4")};
    return camera;
  }
  if (type == "pinhole-radtan8") {
    return opencv_camera(camera,
                         {yaml.number("k1"), yaml.number("k2"), yaml.number("p1"), yaml.number("p2"),
                          yaml.number("k3"), yaml.number("k4"), yaml.number("k5"), yaml.number("k6")},
                         yaml.path(), yaml.line("k1"), name, notes);
  }
  if (type == "ucm") {
    return unified_camera(camera, yaml);
  }
  if (type == "ds") {
    const double xi = yaml.number("xi");
    projection = double_sphere(pinhole, xi, yaml.number("alpha"));
    camera.fu /= 1.0 + xi;
    camera.fv /= 1.0 + xi;
  } else if (type == "eucm") {
    projection = extended_unified(pinhole, yaml.number("alpha"), yaml.number("beta"));
  } else {
    entry.fail("camera_type", "camera_type pinhole, pinhole-radtan8, kb4, ds, ucm or eucm", excerpt(type));
  }
  return fitted(projection, camera, yaml.path(), entry.line("camera_type"), name + " (" + type + ")", notes);
}

Camera size_of(const std::vector<double>& sizes, std::size_t camera) {
  Camera out;
  out.width = static_cast<int>(sizes[2 * camera]);
  out.height = static_cast<int>(sizes[2 * camera + 1]);
  return out;
}

/// Of three axes the largest.
std::optional<double> largest(const SensorYaml& yaml, const std::string& key) {
  if (!yaml.has(key)) {
    return std::nullopt;
  }
  const Eigen::Vector3d values = yaml.not_negative3(key);
  return values.maxCoeff();
}

std::optional<ImuNoise> basalt_noise(const SensorYaml& yaml) {
  const auto gyro = largest(yaml, "gyro_noise_std"), gyro_walk = largest(yaml, "gyro_bias_std"),
             accel = largest(yaml, "accel_noise_std"), accel_walk = largest(yaml, "accel_bias_std");
  if (!gyro || !gyro_walk || !accel || !accel_walk) {
    return std::nullopt;
  }
  return ImuNoise{*gyro, *gyro_walk, *accel, *accel_walk};
}

/// Biases come first; what follows scales and skews the samples.
void note_corrections(const SensorYaml& yaml, std::vector<std::string>& notes) {
  for (const char* const key : {"calib_accel_bias", "calib_gyro_bias"}) {
    if (!yaml.has(key)) {
      continue;
    }
    const auto values = yaml.numbers(key);
    if (std::any_of(values.begin() + std::min<std::ptrdiff_t>(3, std::ssize(values)), values.end(),
                    [](double value) { return value != 0.0; })) {
      notes.push_back(fmt::format("{}: its scale and misalignment of the IMU are not applied", key));
    }
  }
}

}  // namespace

RigFile read_basalt_rig(const SensorYaml& yaml) {
  RigFile out;
  out.format = "Basalt JSON";
  const auto cameras = yaml.sections("intrinsics", 2);
  const auto places = yaml.sections("T_imu_cam", 2);
  const auto sizes = yaml.entries("resolution");
  if (sizes.size() != 4 || *std::min_element(sizes.begin(), sizes.end()) < 1.0) {
    yaml.fail("resolution", "two times [width, height]", fmt::format("{} numbers", sizes.size()));
  }
  out.calibration.cam0 = basalt_camera(cameras[0], size_of(sizes, 0), "cam0", out.notes);
  out.calibration.cam1 = basalt_camera(cameras[1], size_of(sizes, 1), "cam1", out.notes);
  place_on_imu(out.calibration, basalt_pose(places[0]), basalt_pose(places[1]));
  if (yaml.has("cam_time_offset_ns")) {  // t_imu = t_cam + offset
    out.calibration.time_offset_s.fill(kNanosecond * yaml.number("cam_time_offset_ns"));
  }
  out.imu_noise = basalt_noise(yaml);
  note_corrections(yaml, out.notes);
  check_rig(out, yaml.path(), yaml.line("T_imu_cam"), "are the cameras swapped?");
  return out;
}

}  // namespace limber::detail
