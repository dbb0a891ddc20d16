// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/sensors/camera.hpp"

/// How limber writes a sensor.yaml.
namespace limber::detail {

/// Ends the line of the intrinsics: limber's hand.
inline constexpr const char* kIntrinsicsMark = "fu, fv, cu, cv; written by limber\n";

/// "[1, 2, 3]", with all digits. @throws std::invalid_argument if one is not finite
[[nodiscard]] std::string list_of(const double* begin, std::size_t count);
[[nodiscard]] std::string list_of(const std::vector<double>& values);

[[nodiscard]] std::string T_BS_text(const Pose& T_body_sensor);

[[nodiscard]] std::string camera_yaml(const Camera& camera, const Pose& T_body_cam);

}  // namespace limber::detail
