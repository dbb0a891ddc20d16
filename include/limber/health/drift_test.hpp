// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "limber/health/change_test.hpp"

/// @file
/// Whether a rig drifts: a line over windows, against the waves beside it.
namespace limber {

/// @brief What is known of how a line scatters over windows of a rig that does not drift.
///
/// The covariance of a line says what windows vary by that have nothing to do with each other. They have, and
/// what that does to a line it does to the slowest waves beside it, which no drift makes.
/// @param waves  of the same windows, see robust_waves()
/// @note docs/derivations/health.md
[[nodiscard]] Scatters scatter_of_waves(const std::vector<BetaEstimate>& waves, const ChangeWays& ways);

/// @brief p-value of the line that fits the windows, of all ways in which a change matters together.
/// @param trend  of these windows, five or more
/// @return infinite where no way matters
[[nodiscard]] double chance_of_drift(const std::vector<RigEvidence>& windows, const BetaTrend& trend,
                                     const RigParameters& theta, bool metric, const Tolerance& tolerance);

/// @brief How many independent tests a line over so many windows is worth, beside the one a window before.
///
/// Of independent Gaussian windows the p-value of a way falls below p in 1.8 p / sqrt(n) of the windows anew
/// (n windows so far) by their true variance, by what is known of it in 0.7 p / sqrt(n) at 1e-2 and fewer
/// below. Windows of realistic pixels are less even: one is between.
[[nodiscard]] double drift_tests_of_window(std::size_t windows);

}  // namespace limber
