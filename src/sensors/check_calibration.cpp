// SPDX-License-Identifier: MIT
#include <cmath>
#include <stdexcept>
#include <string>

#include "limber/core/so3.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/parameters.hpp"

namespace limber {

namespace {

[[noreturn]] void refuse(const std::string& name, double value, const std::string& expected) {
  throw std::invalid_argument("calibration: " + name + " is " + std::to_string(value) + ", expected " +
                              expected);
}

void require_finite(const std::string& name, double value) {
  if (!std::isfinite(value)) {
    refuse(name, value, "a finite number");
  }
}

void require_focal_length(const std::string& name, double value) {
  if (!std::isfinite(value) || value <= 0.0) {
    refuse(name, value, "a positive number of pixels");
  }
}

void check_camera(const std::string& name, const Camera& camera) {
  require_focal_length("fu of " + name, camera.fu);
  require_focal_length("fv of " + name, camera.fv);
  require_finite("cu of " + name, camera.cu);
  require_finite("cv of " + name, camera.cv);
  for (const double value : coefficients(camera.distortion)) {
    require_finite("a distortion coefficient of " + name, value);
  }
  if (!project(camera, Eigen::Vector3d::UnitZ())) {  // omni with xi <= -1
    throw std::invalid_argument("calibration: the distortion of " + name +
                                ": expected a lens that sees straight ahead, found one that does not");
  }
}

void check_rig(const StereoCalibration& calibration) {
  for (Eigen::Index k = 0; k < kBlockSize; ++k) {
    require_finite(std::string(kParameterNames[static_cast<std::size_t>(k)]) + " of theta",
                   calibration.theta(k));
  }
  if (!(calibration.baseline() > 0.0)) {
    refuse("the baseline", calibration.baseline(), "a positive number of metres");
  }
}

void check_mount(const Pose& T_body_cam0) {
  require_rotation(T_body_cam0.R, "calibration: the rotation of T_body_cam0");
  for (const double value : T_body_cam0.p) {
    require_finite("a coordinate of T_body_cam0", value);
  }
}

}  // namespace

void check_calibration(const StereoCalibration& calibration) {
  check_camera("cam0", calibration.cam0);
  check_camera("cam1", calibration.cam1);
  check_rig(calibration);
  if (calibration.body == BodyFrame::kImu) {
    check_mount(calibration.T_body_cam0);
  }
  for (const std::size_t k : {0U, 1U}) {
    require_finite("the time offset of cam" + std::to_string(k), calibration.time_offset_s[k]);
    require_finite("the readout time of cam" + std::to_string(k), calibration.readout_time_s[k]);
  }
}

}  // namespace limber
