// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

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
/// own covariance (Huber), with a prior that holds where geometry is weak.
/// @param F  6×k, k <= 6: what may be wrong, F Fᵀ is the prior's covariance. Wide for what is constrained;
///           directions that are trusted stay as they are assumed
/// @return theta, close to calibration.theta where nothing is known yet. Nothing in the estimate changes.
/// @note docs/derivations/constrained-update.md
[[nodiscard]] RigParameters operating_point(const Estimate& estimate, const StereoFrame& frame,
                                            const StereoCalibration& calibration, const PixelNoise& sigma_px,
                                            const Eigen::Ref<const Eigen::MatrixXd>& F);

}  // namespace limber
