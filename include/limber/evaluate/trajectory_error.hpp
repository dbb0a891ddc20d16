// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "limber/evaluate/alignment.hpp"
#include "limber/evaluate/association.hpp"
#include "limber/evaluate/statistics.hpp"

/// Trajectory errors by the definitions of the tool evo (github MichaelGrupp/evo, metrics APE and RPE).
namespace limber {

/// Statistics of a list of pose errors.
struct PoseErrorStatistics {
  Statistics position_m;    ///< distances [m]
  Statistics attitude_deg;  ///< rotation angles [deg], 0 to 180
};

/// @brief Absolute errors: aligned estimate against truth, pose by pose.
/// @throws std::invalid_argument if there are no poses or the alignment's status is not kAligned
[[nodiscard]] PoseErrorStatistics absolute_errors(std::span<const MatchedPose> poses,
                                                  const Alignment& alignment);

/// Indices (from, to) of the poses that a relative error compares.
using IndexPair = std::pair<std::size_t, std::size_t>;

/// All pairs (i, i + delta). Empty if there are not that many poses.
/// @throws std::invalid_argument if delta is zero
[[nodiscard]] std::vector<IndexPair> pairs_by_frames(std::size_t poses, std::size_t delta);

/// @brief From each pose to the later one whose distance along the *estimated* path is nearest to `distance`
/// [m]. Pairs that miss it by more than `relative_tolerance * distance` are left out.
/// @throws std::invalid_argument unless distance > 0 and relative_tolerance >= 0
[[nodiscard]] std::vector<IndexPair> pairs_by_path(std::span<const MatchedPose> poses, double distance,
                                                   double relative_tolerance = 0.1);

/// @brief Stretches of the *true* path, one after the other, each about `distance` [m] long: from a pose to
/// the first one that is so much further, and on from there. What is left at the end belongs to none.
/// @throws std::invalid_argument unless distance > 0
[[nodiscard]] std::vector<IndexPair> disjoint_pieces(std::span<const MatchedPose> poses, double distance);

/// A relative error.
struct RelativeError {
  /// lengths of the translation and of the rotation that the estimate is off by over a piece
  double position_m = 0.0, attitude_deg = 0.0;
};

/// @brief The relative error of each pair, see relative_errors.
/// @throws std::invalid_argument if there are fewer poses than a pair says
[[nodiscard]] std::vector<RelativeError> relative_errors_of(std::span<const MatchedPose> poses,
                                                            std::span<const IndexPair> pairs);

/// @brief Relative errors, E = (T_true_i⁻¹ T_true_j)⁻¹ (T_est_i⁻¹ T_est_j): no alignment enters.
/// @return nothing if there are no pairs
[[nodiscard]] std::optional<PoseErrorStatistics> relative_errors(std::span<const MatchedPose> poses,
                                                                 std::span<const IndexPair> pairs);

/// Length [m] of the estimated and of the true path through the matched poses.
[[nodiscard]] double estimated_path_length(std::span<const MatchedPose> poses);
/// Length of the true path through the matched poses [m].
[[nodiscard]] double true_path_length(std::span<const MatchedPose> poses);

}  // namespace limber
