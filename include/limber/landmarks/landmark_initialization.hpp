// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "limber/measure/rig.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

/// How a new point enters the map.
enum class LandmarkInitMode : std::uint8_t {
  kClassical,  ///< all its pixels are spent at once, with cross-covariances (ekf, ekf-full, consider)
  kDiffuse     ///< what theta touches is left huge for the same frame's constrained update (lcekf, soft)
};

/// Numbers of the initialisation.
struct LandmarkInitOptions {
  /// which pixels are spent at once
  LandmarkInitMode mode = LandmarkInitMode::kDiffuse;
  /// how the new point's triplet is to be read
  LandmarkKind kind = LandmarkKind::kInverseDepth;
  /// Diffuse: standard deviation of the inverse depth, in units of one over the baseline [-].
  double inverse_depth_sigma_baselines = 0.5;
  /// Diffuse, Cartesian: standard deviation per axis [m].
  double cartesian_sigma = 1000.0;
  /// Seen by the left camera alone: prior of the inverse depth [1/m].
  double mono_inverse_depth = 0.1;
  /// standard deviation of that [1/m]
  double mono_inverse_depth_sigma = 0.5;
};

/// Which rows of the new landmark's own frame are still to be used by the stacked update.
enum class RemainingRows : std::uint8_t { kNone, kRight, kAll };

/// @brief A point that the left camera alone sees begins at the median distance of those in the map: prior of
/// its inverse depth.
/// @param since_ns  of landmarks seen since then whose depths are known; with fewer than five `options` stay
void guess_depth_as_in_map(const Estimate& estimate, const MountedCamera& cam0, std::int64_t since_ns,
                           LandmarkInitOptions& options);

/// @brief Puts a new point into the map.
/// @param anchor  index of this frame's anchor; ignored for Cartesian landmarks
/// @return the rows left for the same frame's update; nothing if the point was not initialised: no left
/// pixel, pixel outside
///         the camera model, or depth unknown to a Cartesian landmark. The estimate is then as it was.
/// @note [Vivet2022], Sec. 3.3, Eqs. (29)-(32); inverse depth after [Civera2008].
[[nodiscard]] std::optional<RemainingRows> initialize_landmark(
    Estimate& estimate, const StereoObservation& observation, const MountedRig& rig,
    const PixelNoise& sigma_px, std::int64_t t_ns, int anchor, const LandmarkInitOptions& options);

}  // namespace limber
