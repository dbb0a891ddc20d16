// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// What two frames of the left camera say of its motion.
struct TwoViews {
  Eigen::Vector3d turn;  ///< rotation vector of R_from_to [rad], in the body frame
  /// How far points lie from where the motion and their best depths put them: four of five lie nearer [px].
  double left_px = 0.0;
  /// Standard deviation of a turn about an axis across the view, over what it were if nothing moved.
  double confusion = 1.0;
};

/// @brief How the body turned between two frames, by the left camera alone: two-view least squares with Huber
/// weights, in which the depth of each point is eliminated (so only the distance from its epipolar line
/// counts). Stereo only gives the depths to start from: errors of them, of the rig or constant along a track,
/// would make a motion sideways look like a turn.
/// @return nothing with fewer than ten points that both frames see
[[nodiscard]] std::optional<TwoViews> left_motion(const StereoCalibration& calibration,
                                                  const StereoFrame& from, const StereoFrame& to);

/// A point of the left camera, z = 1, whose place depends on a parameter.
struct MovingPoint {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< of the place, by the parameter
  std::optional<double> inverse_depth;              ///< along the bearing, by stereo [1/m]
};
using MovingPoints = std::unordered_map<std::int64_t, MovingPoint>;  ///< by track_id

/// What two frames of the left camera say of the parameter: least squares in `information` and `gradient`,
/// in standard deviations of kPixel; `squares` are left of the residuals of so many points.
struct ParameterFit {
  double information = 0.0, gradient = 0.0, squares = 0.0;
  std::size_t points = 0;
};

/// @brief As left_motion, with a parameter of the camera as a seventh unknown, known to 0.05 beforehand: a
/// readout time or a lens bend what no motion of a rigid world explains.
[[nodiscard]] std::optional<ParameterFit> parameter_between(const MovingPoints& from, const MovingPoints& to,
                                                            double focal_px, double baseline);

}  // namespace limber::detail
