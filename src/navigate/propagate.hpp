// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "limber/navigate/navigator_options.hpp"
#include "limber/predict/input_buffer.hpp"
#include "limber/predict/input_noise.hpp"
#include "limber/predict/motion.hpp"

namespace limber::detail {

/// A body's state carried through some steps.
struct Propagation {
  NavigationState nav;
  Transition whole;             ///< of all steps
  Eigen::Vector3d omega_input;  ///< [rad/s], of the last step
  /// By how much the body's error is off for each second that an IMU's samples are stamped later than they
  /// were taken [unit/s]; nothing of other inputs, and where a time offset is estimated anyway.
  Eigen::VectorXd by_clock;
};

/// @brief Carries the body through the steps by the options' motion model.
///
/// Where samples are missing, an IMU's mean goes from what was measured last (or will be measured next) to
/// none: no rotation and no acceleration, biases kept; odometry's stays what it was. What may have happened
/// instead is noise.
/// @param usual_interval_s   between samples; odometry only
/// @param more              noise of the inputs beyond all that
[[nodiscard]] Propagation propagate(const NavigationState& nav, const std::vector<InputStep>& steps,
                                    const NavigatorOptions& options, const OdometryNoise& odometry_noise,
                                    const ConstantVelocityNoise& motion_noise, double usual_interval_s,
                                    const MoreNoise& more);

}  // namespace limber::detail
