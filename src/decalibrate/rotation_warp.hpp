// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "limber/sensors/camera.hpp"

namespace limber::decalibrate {

/// @brief What a camera sees after it has turned about its centre, made from what it saw before. Raw pixels
/// to raw pixels, through any lens.
class RotationWarp {
 public:
  explicit RotationWarp(const Camera& camera);

  /// @param image  of the camera's size; 8 or 16 bit, any number of channels
  /// @param turn   R with bearing_after = R bearing_before
  [[nodiscard]] cv::Mat operator()(const cv::Mat& image, const Eigen::Matrix3d& turn);

  /// Share of the last image that the camera had not seen before: black.
  [[nodiscard]] double black_share() const { return black_share_; }

 private:
  void make_map(const Eigen::Matrix3d& turn);

  Camera camera_;
  std::vector<std::optional<Eigen::Vector3d>> bearings_;  ///< of the pixels, row by row
  cv::Mat map_;                                           ///< pixel after -> pixel before
  cv::Mat black_;                                         ///< 255 where there is none
  Eigen::Matrix3d turn_ = Eigen::Matrix3d::Zero();        ///< that the map stands for
  double black_share_ = 0.0;
};

}  // namespace limber::decalibrate
