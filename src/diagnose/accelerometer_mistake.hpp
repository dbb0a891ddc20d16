// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// @brief An accelerometer whose sign or axes are not those of the gyro and of T_BS: of how the body
/// accelerated by the cameras it explains less than a quarter, and more than 60 % with other signs or axes.
/// @param imu  at least two samples, in order of time, with a gyro that is right
[[nodiscard]] std::optional<std::string> accelerometer_mistake(const StereoCalibration& calibration,
                                                               std::span<const StereoFrame> frames,
                                                               std::span<const ImuSample> imu);

}  // namespace limber::detail
