// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

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

/// The true rig at one instant; for evaluation and for `oracle` only.
struct CalibrationTruth {
  /// [ns]
  std::int64_t t_ns = 0;
  /// true, not assumed [rad, m]
  RigParameters theta = RigParameters::Zero();
};

/// @brief One recording in limber's own conventions, whatever format it came from.
/// Every list is in strictly increasing time. What the recording does not hold is empty.
struct Recording {
  /// of the folder or file, for reports
  std::string name;
  /// where it was read from; empty for one from memory
  std::filesystem::path path;

  // What an estimator may use.
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

  // Truth, for evaluation only (and `--init groundtruth`, `oracle`).
  std::vector<GroundTruthState> groundtruth;  ///< body in world
  /// false: its velocities are zero
  bool groundtruth_has_velocity = false;
  /// false: its biases are zero
  bool groundtruth_has_biases = false;
  std::map<std::int64_t, Eigen::Vector3d> landmarks_true;  ///< track_id -> p_world_landmark [m]
  /// theta_true(t); empty where nobody knows it
  std::vector<CalibrationTruth> calibration_true;

  bool partial = false;            ///< parts of it are damaged or missing and left out; `notes` say which
  std::vector<std::string> notes;  ///< defaults that stood in for missing values, in plain words
};

}  // namespace limber
