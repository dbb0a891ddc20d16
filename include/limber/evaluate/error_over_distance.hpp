// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "limber/evaluate/association.hpp"

/// @file
/// Relative errors over pieces of several lengths: how an estimate drifts.
namespace limber {

/// Mean and quartiles of errors, in their unit.
struct ErrorSpread {
  double mean = 0.0, lower = 0.0, median = 0.0, upper = 0.0;  ///< lower, upper: quartiles
};

/// Relative errors of all pieces of one length, see relative_errors_of.
struct ErrorOverDistance {
  double distance = 0.0;         ///< along the estimated path [m]
  std::size_t pairs = 0;         ///< pieces, one from each pose where there is one: they overlap
  ErrorSpread position_percent;  ///< of the distance
  ErrorSpread attitude_deg;      ///< [deg] at the end of a piece
};

/// Round lengths (1, 2, 5, 10, ...) from a hundredth of the true path to half of it [m]; may be empty.
[[nodiscard]] std::vector<double> round_distances(std::span<const MatchedPose> poses);

/// @brief For each length the errors over pairs_by_path of it, within `relative_tolerance`. Lengths without a
/// pair are left out. No alignment enters.
/// @throws std::invalid_argument as pairs_by_path
[[nodiscard]] std::vector<ErrorOverDistance> errors_over_distances(std::span<const MatchedPose> poses,
                                                                   std::span<const double> distances,
                                                                   double relative_tolerance = 0.1);

}  // namespace limber
