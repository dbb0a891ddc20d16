// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/health/rig_window.hpp"

/// @file
/// What windows say together of the rig, as a constant or as a line over time.
namespace limber {

/// Variance of the relative length of a metre that no input knows.
inline constexpr double kUnknownScale = 0.25;
/// Relative error of a metre: no sensor is believed to know it better.
inline constexpr double kLeastScale = 0.01;

/// @brief The baseline that was found, all of it, as an error of the rig [plausible errors]: a trajectory
/// that is too long makes it so, by the same share, and no epipolar line shows that.
/// @param theta  assumed
/// @param beta   the error that was found
[[nodiscard]] NormalEquations::Vector along_length(const RigParameters& theta,
                                                   const NormalEquations::Vector& beta);

/// The rig's error, true minus assumed theta [rad, m], and a covariance that counts tracks and places in the
/// image, not pixels.
struct RigEstimate {
  /// [rad, m]
  RigParameters delta = RigParameters::Zero();
  /// of delta [rad², rad m, m²]
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Roots of the covariance's diagonal [rad, m].
  [[nodiscard]] RigParameters sigma() const;
};

/// The same with all of beta, and what it does to the points that were seen.
struct BetaEstimate {
  /// [plausible errors]
  NormalEquations::Vector beta = NormalEquations::Vector::Zero();
  /// of beta
  NormalEquations::Matrix covariance = NormalEquations::Matrix::Zero();
  /// betaᵀ epipolar beta: mean square of the distance to the epipolar line [px^2].
  NormalEquations::Matrix epipolar = NormalEquations::Matrix::Zero();
  /// Part of the covariance of a step: what windows vary by beyond what their clusters say.
  NormalEquations::Matrix between = NormalEquations::Matrix::Zero();

  /// The six of the rig in units of theta: without the lens.
  /// @param theta  assumed, tells one plausible error
  [[nodiscard]] RigEstimate rig(const RigParameters& theta) const;
};

/// @brief The estimate of windows together: two-way clusters (track and cell: V_track + V_cell − V_both), and
/// windows as clusters as they become many. Of few windows the covariance is enlarged (threefold for one):
/// what all points of a window share, such as an error of its poses, shows between windows alone.
/// @param metric  the trajectory knows how long a metre is; else nothing is said of the baseline's length
[[nodiscard]] BetaEstimate robust_estimate(const std::vector<RigEvidence>& windows,
                                           const RigParameters& theta, bool metric);

/// @brief Of vision alone windows find the baseline as long as the trajectory's scale makes it. Beyond what
/// may be believed of that scale it is lost, and what is linear about such a baseline means nothing.
/// @param theta  assumed
[[nodiscard]] bool loses_scale(const BetaEstimate& estimate, const RigParameters& theta);

/// @brief The same, with a baseline that may as well be as long as assumed: one sigma.
/// @param theta  assumed
[[nodiscard]] BetaEstimate with_unknown_length(const BetaEstimate& estimate, const RigParameters& theta);

/// The same, had vergence been known to be the assumed one: without what depths say of it.
[[nodiscard]] BetaEstimate with_assumed_vergence(const BetaEstimate& estimate, const RigParameters& theta);

/// A rig that drifts: the error at the end of the last window, and how it changed from the middle of the
/// first window to that of the last.
struct BetaTrend {
  /// at the end of the last window; over `seconds`
  BetaEstimate now, change;
  NormalEquations::Matrix covariance = NormalEquations::Matrix::Zero();  ///< of now and change
  double seconds = 0.0;  ///< between the middles of the first and the last window
};

/// @brief The same with an error that is a line over time.
/// @param windows  at least three
[[nodiscard]] BetaTrend robust_trend(const std::vector<RigEvidence>& windows, const RigParameters& theta,
                                     bool metric);

/// @brief Waves of 1, 3/2, 2, ... periods over all windows, each fitted beside a line: how windows vary
/// slowly without drifting.
/// @param windows  at least four
/// @return the amplitudes, the slowest first
[[nodiscard]] std::vector<BetaEstimate> robust_waves(const std::vector<RigEvidence>& windows,
                                                     std::size_t count);

/// @brief Where the rig is at the end, if it drifts by no more than is to be expected.
/// @param expected  covariance of the change over the windows, before they are seen. Zero: a constant error
[[nodiscard]] BetaEstimate with_drift_within(const BetaTrend& trend, const NormalEquations::Matrix& expected);

/// @brief By how much the rig changed at moments between which it is constant: what lenses do wrong is the
/// same before and after, and cancels. What windows share that see the same tracks is in the covariance.
/// @param firsts  window after each moment, increasing. The one before it holds the moment and is left out;
/// at
///                least one is left of each state
[[nodiscard]] std::vector<BetaEstimate> robust_steps(const std::vector<RigEvidence>& windows,
                                                     const std::vector<std::size_t>& firsts,
                                                     const RigParameters& theta, bool metric);

}  // namespace limber
