// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <functional>

#include "limber/measure/rig.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

/// The right camera where the parameters are off the assumed ones by a vector of theirs.
using CameraOff = std::function<MountedCamera(const Eigen::VectorXd& off)>;

/// @brief How far from the assumed calibration a constrained frame is best linearised: what the right pixels
/// of known landmarks say that it is off by, right now.
///
/// A gain with L D C = 0 does not care where in the parameters it is linearised, to first order. To second
/// order it does: a new landmark's inverse depth multiplies theta, so that a baseline that is 25 % off puts 6
/// % into the depth that the same frame's update would then believe. Gauss-Newton, each point weighted by its
/// own covariance (Huber), with a prior that holds where geometry is weak; one step where that moves no pixel
/// far. (In one step 5 degrees of vergence, of which a pixel is no linear function, came out as 5 degrees and
/// a baseline that points 40 degrees aside.)
/// @param cam1  as the calibration mounts it that differs from the assumed one by what is returned
/// @param F     c×k: what may be wrong, F Fᵀ is the prior's covariance. Wide for what is constrained;
///              directions that are trusted stay as they are assumed. c is 6, or all parameters if cam1 was
///              mounted with them
/// @return c: zero where nothing is known yet. Nothing in the estimate changes.
/// @note docs/derivations/constrained-update.md
[[nodiscard]] Eigen::VectorXd linearization_point(const Estimate& estimate, const StereoFrame& frame,
                                                  const CameraOff& cam1, const PixelNoise& sigma_px,
                                                  const Eigen::Ref<const Eigen::MatrixXd>& F);

}  // namespace limber
