// SPDX-License-Identifier: MIT
#pragma once

namespace limber {

/// Which way each file writes where a camera stands, to be said of one that is inverted.
inline constexpr const char* kDirections =
    ": it maps camera to IMU coordinates, as Kalibr's T_imu_cam does; Kalibr's T_cam_imu is its inverse";

}  // namespace limber
