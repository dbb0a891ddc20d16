// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/health/rig_window.hpp"

/// @file
/// What windows say together of the rig, as a constant or as a line over time.
namespace limber {

/// The rig's error, true minus assumed theta [rad, m], and a covariance that counts tracks and places in the
/// image, not pixels.
struct RigEstimate {
  RigParameters delta = RigParameters::Zero();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  [[nodiscard]] RigParameters sigma() const { return covariance.diagonal().cwiseSqrt(); }
};

/// The same with all of beta, and what it does to the points that were seen.
struct BetaEstimate {
  NormalEquations::Vector beta = NormalEquations::Vector::Zero();
  NormalEquations::Matrix covariance = NormalEquations::Matrix::Zero();
  /// betaᵀ epipolar beta: mean square of the distance to the epipolar line [px^2].
  NormalEquations::Matrix epipolar = NormalEquations::Matrix::Zero();

  [[nodiscard]] RigEstimate rig(const RigParameters& theta) const;
};

/// @brief The estimate of windows together: two-way clusters (track and cell: V_track + V_cell − V_both), and
/// windows as clusters as they become many. Of few windows the covariance is enlarged (threefold for one):
/// what all points of a window share, such as an error of its poses, shows between windows alone.
/// @param metric  the trajectory knows how long a metre is; else nothing is said of the baseline's length
[[nodiscard]] BetaEstimate robust_estimate(const std::vector<RigEvidence>& windows,
                                           const RigParameters& theta, bool metric);

/// A rig that drifts: the error at the last window, and how it changed from the first window to it.
struct BetaTrend {
  BetaEstimate now, change;
  double seconds = 0.0;  ///< between the middles of the first and the last window
};

/// @brief The same with an error that is a line over time.
/// @param windows  at least three
[[nodiscard]] BetaTrend robust_trend(const std::vector<RigEvidence>& windows, const RigParameters& theta,
                                     bool metric);

}  // namespace limber
