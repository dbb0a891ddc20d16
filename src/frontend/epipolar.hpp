// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

/// What two views of the same points say about each other. No calibrated extrinsics in here.
namespace limber::frontend {

/// Unit bearings of one point in two views, a and b.
struct BearingPair {
  Eigen::Vector3d a, b;
};

/// X_b = R_b_a X_a + t, with t of unit length: what a set of pairs can say.
struct EpipolarGeometry {
  Eigen::Matrix3d R_b_a;
  Eigen::Vector3d t;
};

/// Sampson distance [rad] of a pair from the geometry, on the sphere (valid for any field of view).
[[nodiscard]] double epipolar_distance(const EpipolarGeometry& geometry, const BearingPair& pair);

/// For each pair, whether it is within `threshold` [rad] of the geometry.
[[nodiscard]] std::vector<bool> epipolar_inliers(const EpipolarGeometry& geometry,
                                                 const std::vector<BearingPair>& pairs, double threshold);

/// @brief The geometry that most pairs agree on: that of `start`, refined, if 95 % of the pairs agree with
/// it; else by five-point RANSAC [Nister2004] with refinement.
/// @param start  may be nothing: what it was a frame ago
/// @return nothing if fewer than `kMinPairs` or less than 60 % of the pairs agree on one geometry.
[[nodiscard]] std::optional<EpipolarGeometry> fit_epipolar(
    const std::vector<BearingPair>& pairs, double threshold,
    const std::optional<EpipolarGeometry>& start = std::nullopt);
inline constexpr int kMinPairs = 12;

/// @brief Robust least squares from a start that is right to some thresholds. What the pairs do not fix (t
/// when nothing moves) stays near the start.
[[nodiscard]] EpipolarGeometry refine_epipolar(const EpipolarGeometry& start,
                                               const std::vector<BearingPair>& pairs, double threshold);

/// @brief The left-right geometry as the matches themselves show it.
/// The pairs of recent frames together fix it; the pairs of the present frame then may move it a little,
/// since a rig that bends is not the same twice. If they contradict it, they are asked alone.
class LeftRightConsensus {
 public:
  explicit LeftRightConsensus(double threshold) : threshold_(threshold) {}

  /// @brief Takes the candidate matches of the next frame.
  /// @return for each, whether it agrees with the geometry; all false while there is none
  [[nodiscard]] std::vector<bool> judge(const std::vector<BearingPair>& pairs);

 private:
  double threshold_;                             ///< [rad]
  std::deque<std::vector<BearingPair>> recent_;  ///< candidates of the latest frames that had any
  std::optional<EpipolarGeometry> geometry_;
};

}  // namespace limber::frontend
