// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "limber/sensors/parameters.hpp"

/// Errors and sizes of calibration parameters as a user writes them: degrees, metres, pixels and seconds;
/// with
/// %, of the baseline (tx, ty, tz) or of the focal length (fu, fv).
namespace limber {

/// @brief "ax,ay,az,tx,ty,tz", six numbers; "NAME=VALUE,..." for any parameters; or the six and then the
/// others: "0,0,0,5%,0,0,dt1=0.002".
/// @param calibration  what a percentage refers to
/// @throws std::invalid_argument that says what was expected
[[nodiscard]] ParameterVector parse_calibration_error(const std::string& text,
                                                      const StereoCalibration& calibration);

/// @brief "NAME[=SIGMA],...": standard deviations of the named parameters or groups, one plausible error
/// where none is given; zero for all others.
/// @throws std::invalid_argument that says what was expected
[[nodiscard]] ParameterVector parse_parameter_sigmas(const std::string& text,
                                                     const StereoCalibration& calibration);

/// "NAME=VALUE,..." of what is not zero, in degrees, metres, pixels and seconds.
[[nodiscard]] std::string format_parameters(const ParameterVector& values);

/// To degrees where the unit is radians, else as it is.
[[nodiscard]] double in_user_units(std::size_t parameter, double value);

/// Unit of in_user_units: "deg", "m", "px", "s" or "-".
[[nodiscard]] std::string user_unit_of(std::size_t parameter);

}  // namespace limber
