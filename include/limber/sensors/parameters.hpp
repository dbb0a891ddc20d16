// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "limber/sensors/calibration.hpp"

/// @file
/// Everything a stereo calibration may be wrong about, by name and in one order.
namespace limber {

/// Parameters come six at a time: the rig theta, then what is said of each camera alone, then where cam0 sits
/// on the body.
enum class ParameterBlock : std::size_t { kTheta, kCam0, kCam1, kMount };

inline constexpr Eigen::Index kBlockSize = 6;                              ///< parameters in a block
inline constexpr Eigen::Index kParameters = 24;                            ///< parameters in all
inline constexpr Eigen::Index kMoreParameters = kParameters - kBlockSize;  ///< those beyond theta

/// Names on the command line.
///
/// theta: ax, ay, az [rad], tx, ty, tz [m]. Camera k: focal lengths fuk, fvk and principal point cuk, cvk
/// [px], radialk, the first radial coefficient of its distortion [-], and dtk, how much later than its stamp
/// an image was taken [s]. Mount: cam0 turned (imu-ax ... [rad]) and shifted (imu-tx ... [m]) on the body, in
/// body axes; cam1 goes with it.
inline constexpr std::array<std::string_view, kParameters> kParameterNames = {
    "ax",     "ay",     "az",     "tx",     "ty",      "tz",       //
    "fu0",    "fv0",    "cu0",    "cv0",    "radial0", "dt0",      //
    "fu1",    "fv1",    "cu1",    "cv1",    "radial1", "dt1",      //
    "imu-ax", "imu-ay", "imu-az", "imu-tx", "imu-ty",  "imu-tz"};  //

/// Which of the parameters are meant, one bit each.
using ParameterSet = std::bitset<kParameters>;
/// Errors, or standard deviations, of all parameters in the order of their names.
using ParameterVector = Eigen::Matrix<double, kParameters, 1>;

/// First parameter of a block.
[[nodiscard]] constexpr Eigen::Index first_of(ParameterBlock block) {
  return kBlockSize * static_cast<Eigen::Index>(block);
}

/// The members of a block.
[[nodiscard]] ParameterSet parameters_of(ParameterBlock block);
/// Those that are not zero.
[[nodiscard]] ParameterSet parameters_of(const ParameterVector& values);

/// What a name stands for: itself, or one of the groups theta, intrinsics0, intrinsics1 (focal lengths,
/// principal point and radial coefficient) and imu (the mount), in any case; nothing for another word.
[[nodiscard]] std::optional<ParameterSet> parameters_named(std::string_view name);

/// All names that parameters_named knows.
[[nodiscard]] const std::vector<std::string>& parameter_words();

/// "rad", "m", "px", "s" or "-".
[[nodiscard]] std::string_view unit_of(std::size_t parameter);

/// One plausible error of each parameter. Theta: 0.1 deg, 5 % of the baseline. Focal lengths: 0.5 %;
/// principal point: 2 px; radial coefficient: 0.01; time offset: 2 ms; mount: 0.5 deg and 2 cm.
[[nodiscard]] ParameterVector plausible_errors(const StereoCalibration& calibration);

/// @brief The calibration that differs from the given one by `error`: additive, rotations of the mount from
/// the left (R := Exp(error) R). A radial coefficient makes a camera without distortion a radial-tangential
/// one.
[[nodiscard]] StereoCalibration corrected(const StereoCalibration& calibration, const ParameterVector& error);

}  // namespace limber
