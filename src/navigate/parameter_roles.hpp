// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>

#include "limber/navigate/stereo_filter.hpp"

/// What a navigator makes of each parameter of the calibration: read off its options, once and for all.
namespace limber::detail {

/// The blocks of StateLayout::has_more, in its order.
inline constexpr std::array kMoreBlocks = {ParameterBlock::kCam0, ParameterBlock::kCam1,
                                           ParameterBlock::kMount};

inline constexpr double kTrustedSigma =
    1e-3;  ///< plausible errors: theta of adaptive, as long as it trusts the rig
inline constexpr double kLensSigma = 0.03;  ///< plausible errors: what lenses leave of a rig that ekf trusts,
                                            ///< 0.024 px at a focal length of 460
inline constexpr double kNotEstimated =
    1e-6;  ///< plausible errors: keeps P positive definite beside what is estimated

[[nodiscard]] ParameterSet theta_parameters();
/// Of the angles of an odometer's mount that is in doubt: one plausible error each [rad].
[[nodiscard]] Eigen::Vector3d mount_sigma(const StereoCalibration& calibration);
/// theta is in the state whatever else is estimated.
[[nodiscard]] bool always_has_theta(Method method);
[[nodiscard]] ParameterSet estimated(const NavigatorOptions& options);
/// The time offset of the cameras is: an IMU's clock that steps is a part of it.
[[nodiscard]] bool estimates_time_offset(const NavigatorOptions& options);
[[nodiscard]] ParameterSet softened(const NavigatorOptions& options);
[[nodiscard]] bool has_theta(const NavigatorOptions& options);
/// An ekf that has to learn what its pixels are worth: what lenses leave of them looks like a rig that is
/// bent.
[[nodiscard]] bool doubts_lenses(const NavigatorOptions& options);
/// theta is in the state, and no update moves it (Schmidt): of consider, and where lenses are doubted.
[[nodiscard]] bool considers_theta(const NavigatorOptions& options);
/// theta follows its estimate from frame to frame.
[[nodiscard]] bool estimates_theta(const NavigatorOptions& options);
[[nodiscard]] bool constrains(const NavigatorOptions& options);
[[nodiscard]] bool softens(const NavigatorOptions& options);
/// Of odometry's bodies, those whose mount has no other role.
[[nodiscard]] bool can_doubt_mount(const NavigatorOptions& options, const StereoCalibration& calibration);
/// Parameters beyond theta that the filter treats as anything but known.
[[nodiscard]] bool has_more(const NavigatorOptions& options);
/// All of these are estimated, from a constant error on.
[[nodiscard]] bool doubts_by_estimating(const NavigatorOptions& options);
[[nodiscard]] bool watches(const NavigatorOptions& options);
/// The witness lives on the rows that a constraint on theta leaves.
[[nodiscard]] bool has_witness(const NavigatorOptions& options);

/// How wrong ekf-full, consider and soft expect theta to be.
[[nodiscard]] RigParameters theta_sigma(const NavigatorOptions& options,
                                        const StereoCalibration& calibration);
/// Of theta in the state, at the start.
[[nodiscard]] RigParameters theta_prior(const NavigatorOptions& options,
                                        const StereoCalibration& calibration);

/// A column for each parameter of the set: 24×k, one plausible error each.
[[nodiscard]] Eigen::MatrixXd unit_directions(const ParameterSet& set, const ParameterVector& scale);

/// The estimate that a filter begins with: the initial state, and the priors of what it estimates beside.
/// @throws std::invalid_argument if shapes disagree, or as check_calibration and check_initial
[[nodiscard]] Estimate make_estimate(const NavigatorOptions& options, const StereoCalibration& calibration,
                                     const InitialState& initial);

/// @throws std::invalid_argument if options contradict each other, or the calibration
void check_parameters(const NavigatorOptions& options, const StereoCalibration& calibration);

}  // namespace limber::detail
