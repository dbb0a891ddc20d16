// SPDX-License-Identifier: MIT
#include "limber/datasets/replace_calibration.hpp"

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <string>

namespace limber {
namespace {

void take_size(Camera& camera, const Camera& own, const char* name) {
  if (camera.width == 0) {
    camera.width = own.width;
    camera.height = own.height;
  } else if (own.width != 0 && (camera.width != own.width || camera.height != own.height)) {
    throw std::invalid_argument(
        fmt::format("the calibration of {} is for images of {} x {} pixels, the recording's have {} x {}",
                    name, camera.width, camera.height, own.width, own.height));
  }
}

}  // namespace

ImageKind image_kind(const StereoCalibration& calibration) {
  return std::holds_alternative<NoDistortion>(calibration.cam0.distortion) &&
                 std::holds_alternative<NoDistortion>(calibration.cam1.distortion)
             ? ImageKind::kRectified
             : ImageKind::kRaw;
}

void require_calibration_of(const RigFile& rig, ImageKind images, WhoSays who) {
  const ImageKind meant = rig.images == ImageKind::kRaw ? image_kind(rig.calibration) : rig.images;
  // A raw camera may have no distortion to speak of: then both are the same.
  if (images != meant && !(who == WhoSays::kUser && images == rig.images)) {
    throw std::invalid_argument(
        fmt::format("the calibration is of {} images ({}), {} {} ones: give the calibration of these images, "
                    "or say --images {} "
                    "if they are",
                    to_string(meant), meant == ImageKind::kRaw ? "with distortion" : "without distortion",
                    who == WhoSays::kUser ? "said were" : "the recording's own is of", to_string(images),
                    to_string(meant)));
  }
}

void replace_calibration(Recording& recording, const RigFile& rig, std::optional<ImageKind> images) {
  const StereoCalibration& own = recording.calibration;
  require_calibration_of(rig, images.value_or(image_kind(own)),
                         images ? WhoSays::kUser : WhoSays::kRecording);
  StereoCalibration calibration = rig.calibration;
  take_size(calibration.cam0, own.cam0, "cam0");
  take_size(calibration.cam1, own.cam1, "cam1");
  if (calibration.body != BodyFrame::kImu && own.body == BodyFrame::kImu) {
    calibration.T_body_cam0 = own.T_body_cam0;
    recording.notes.emplace_back(
        "the calibration file does not place cam0 on the IMU: the recording's own T_BS stays");
  }
  if (calibration.readout_time_s == std::array{0.0, 0.0}) {  // most formats cannot say it
    calibration.readout_time_s = own.readout_time_s;
  }
  calibration.body = own.body;
  if (own.body == BodyFrame::kCam0) {
    calibration.T_body_cam0 = Pose{};
  }
  recording.calibration = calibration;
  if (rig.imu_noise) {
    recording.imu_noise = rig.imu_noise;
  }
  recording.notes.insert(recording.notes.end(), rig.notes.begin(), rig.notes.end());
}

}  // namespace limber
