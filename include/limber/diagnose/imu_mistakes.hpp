// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// @brief Mistakes of units and of the mount that the IMU shows beside the cameras, each as a sentence with
/// numbers; none if none is found.
///
/// - Accelerometer in g: the median of its length is 1 within 30 % instead of gravity. Without gravity: less
///   than 40 % of it.
/// - Gyro in deg/s, T_BS inverted, axes of the gyro that are not those of T_BS, or with a wrong sign: the
///   gyro explains less than half of how the left camera turned, and more than 80 % without the mistake.
/// - Accelerometer with the wrong sign, or axes that are not the gyro's: second differences of where the body
///   was by stereo, fitted by a matrix times the specific force; an entry that is wrong is told by 5 sigma.
///   Only beside a gyro that is right. What a bent rig does to lengths does not change signs.
/// @param gravity  expected length of the specific force at rest [m/s^2]
[[nodiscard]] std::vector<std::string> imu_mistakes(const StereoCalibration& calibration,
                                                    std::span<const StereoFrame> frames,
                                                    std::span<const ImuSample> imu, double gravity);

}  // namespace limber
