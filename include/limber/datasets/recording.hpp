// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "limber/datasets/ground_truth.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/encoded_image.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// A stereo pair on disk, not loaded. Where a recording has an ImageStore, the paths are those of the bag.
struct ImagePair {
  /// [ns], of both
  std::int64_t t_ns = 0;
  /// files of the images
  std::filesystem::path cam0, cam1;
};

/// What the sensors of a rig gave, and what is assumed of them: all that an estimator may look at.
/// Every list is in strictly increasing time. What was not recorded is empty.
struct SensorData {
  StereoCalibration calibration;  ///< the assumed calibration; body is kImu, or kCam0 for camera-only data
  /// in the frame of the IMU; empty without one
  std::vector<ImuSample> imu;
  /// continuous densities; nothing: the recording does not say
  std::optional<ImuNoise> imu_noise;
  std::vector<OdometrySample> odometry;  ///< body frame velocity and rate
  /// per sample; nothing: the recording does not say
  std::optional<OdometryNoise> odometry_noise;
  /// [px]; nothing: the recording does not say
  std::optional<PixelNoise> pixel_noise;
  std::vector<StereoFrame> frames;  ///< matched points; empty where images are given
  std::vector<ImagePair> images;    ///< stereo pairs; empty where matched points are given
  std::shared_ptr<const ImageStore>
      image_store;  ///< of `images` that are no files of their own (bags); else null
};

/// One recording in limber's own conventions, whatever format it came from: sensor data and ground truth.
struct Recording : SensorData {
  /// of the folder or file, for reports
  std::string name;
  /// where it was read from; empty for one from memory
  std::filesystem::path path;
  /// what an estimator does not see
  RecordingTruth truth;

  bool partial = false;            ///< parts of it are damaged or missing and left out; `notes` say which
  std::vector<std::string> notes;  ///< defaults that stood in for missing values, in plain words
};

}  // namespace limber
