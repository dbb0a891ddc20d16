// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/sensors/calibration.hpp"

namespace limber::detail {

/// Two images whose rows correspond, made from those of a rig.
struct RectifiedPair {
  Eigen::Matrix3d R0, R1;  ///< X_rectified = R X_camera
  double f = 1.0;          ///< both focal lengths, of both images [px]
  double cu = 0.0, cv = 0.0;
  double baseline = 0.0;  ///< [m]

  [[nodiscard]] Eigen::Matrix<double, 3, 4> P0() const;  ///< K [I | 0]
  [[nodiscard]] Eigen::Matrix<double, 3, 4> P1() const;  ///< K [I | (-baseline, 0, 0)]
};

/// Both cameras turn by as little as possible, until x runs along the baseline; the same principal point for
/// both, so that parallel rays have zero disparity.
[[nodiscard]] RectifiedPair rectify(const StereoCalibration& calibration);

}  // namespace limber::detail
