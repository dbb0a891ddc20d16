// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <bitset>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/image_cell.hpp"

/// @file
/// One rig from what several parts of a recording say of it, each for itself.
namespace limber {

using RigMatrix = Eigen::Matrix<double, 6, 6>;  ///< by axis, in the order of RigAxes
using RigAxes = std::bitset<6>;                 ///< ax, ay, az, tx, ty, tz

/// What one part of a recording says of theta: the minimum of its least squares and their curvature.
struct RigPart {
  /// first and last keyframe [ns]
  std::int64_t from_ns = 0, to_ns = 0;
  /// [rad, m]
  RigParameters theta = RigParameters::Zero();
  RigMatrix information = RigMatrix::Zero();  ///< inverse covariance by the noise of the sensors alone
  std::map<int, CellScore> scores;            ///< by image_cell
};

/// A rig with its covariance.
struct RigFit {
  /// [rad, m]; axes that were not seen as given
  RigParameters theta = RigParameters::Zero();
  /// By the noise of the sensors and `spread`, and no less in any direction than by leaving out one image
  /// cell after the other (the jackknife of clusters, [MacKinnon2023]: what a cell's points
  /// have in common in all windows, as errors of a lens model, does not average out), drawn towards the shape
  /// of the noise as far as so few cells leave its own in doubt [Chen2010], times the variance of Student's
  /// t. Axes that were not seen have their bounds as standard deviations, and what the others would change by
  /// with them.
  RigMatrix covariance = RigMatrix::Zero();
  RigAxes seen;  ///< the others keep what was given
  /// How much larger the differences between windows are than the noise of the sensors says (variance, >= 1).
  double spread = 1.0;
};

/// @brief The windows' theta weighted by their information. An axis whose standard deviation is above its
/// bound is left at what was given, the least known first, and the others are solved again; but not where it
/// is off by more than three of them, which a rig that is right within the bound would not be.
/// @param bounds  largest standard deviations of an axis that counts as seen; what is given for the others is
///                taken to be right within them (1 sigma) [rad, m]
/// @throws std::invalid_argument if there is no window
[[nodiscard]] RigFit fit_rig(std::span<const RigPart> windows, const RigParameters& given,
                             const RigParameters& bounds);

/// How far a rig is from what the windows say: the squared distances in their own metric, summed.
[[nodiscard]] double misfit(std::span<const RigPart> windows, const RigParameters& theta);

/// What windows that did not take part say of a rig made from the others.
struct HeldOut {
  double given = 0.0, fitted = 0.0;  ///< misfits, summed over both halves
};

/// @brief Two halves, every second window each: the rig of one is judged by the other.
/// @return zeros with fewer than two windows
[[nodiscard]] HeldOut held_out(std::span<const RigPart> windows, const RigParameters& given,
                               const RigParameters& bounds);

}  // namespace limber
