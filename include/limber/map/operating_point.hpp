// SPDX-License-Identifier: MIT
#pragma once

#include "limber/map/estimate.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// @brief The rig at which a constrained frame is best linearised: the assumed theta plus what the right
/// pixels of known landmarks say that it is off by, right now.
///
/// A gain with L D C = 0 does not care where in theta it is linearised, to first order. To second order it
/// does: a newborn's inverse depth multiplies theta, so that a baseline that is 25 % off puts 6 % into the
/// depth that the same frame's update would then believe. One Gauss-Newton step, each point weighted by its
/// own covariance (Huber), with a wide prior of ten plausible errors (1 deg, 50 % of the baseline) that holds
/// where geometry is weak.
/// @return theta, close to calibration.theta where nothing is known yet. Nothing in the estimate changes.
/// @note docs/derivations/constrained-update.md
[[nodiscard]] RigParameters operating_point(const Estimate& estimate, const StereoFrame& frame,
                                            const StereoCalibration& calibration, const PixelNoise& sigma_px);

}  // namespace limber
