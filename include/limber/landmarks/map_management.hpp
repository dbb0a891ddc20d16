// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "limber/measure/rig.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

/// Rules that keep the map small and well behaved.
struct MapManagementOptions {
  /// Points of a frame that an update takes, at most; the others wait until one of them is lost
  /// (LandmarkBudget). >= 1; all, unless somebody says how many
  std::size_t points_per_update = std::numeric_limits<std::size_t>::max();
  std::size_t max_landmarks = 300;  ///< beyond it, those unseen for longest go
  double forget_after_s = 1e9;  ///< unseen for longer: gone (tracks of an image front end never come back)
  /// Unseen for longer when an epoch ends: made passive at no cost per frame until seen again (compressed
  /// filter). Infinite: never.
  double rest_after_s = 0.1;
  double epoch_s = 0.5;  ///< length of an epoch, between two of which landmarks go to rest
  /// An epoch in which the active state has grown by that many (landmarks that are new or came back) ends
  /// sooner: what its end costs grows with them, and so does each frame.
  Eigen::Index most_growth = 60;
  int max_refusals = 3;  ///< refused by the gate in this many frames in a row: gone
  /// Inverse-depth landmarks become Cartesian when the linearity index of [Civera2008], Eq. (30) falls below.
  double linearity_index = 0.1;
  /// A point that comes back into view after an absence is taken for a new one if its projection bends by
  /// more than this over one standard deviation [px]: a linear update would put it in a wrong place with
  /// great confidence.
  double max_curvature_px = 0.25;
  /// A point initialised under a doubtful calibration is taken for a new one once its inverse depth turns out
  /// to lie this share away from what was assumed at initialisation [-], and is known better than that: its
  /// first frames were linearised at the wrong place.
  double max_depth_shift = 0.1;
  /// A point whose depth was guessed is taken for a new one when the right camera tells it, unless its
  /// inverse depth is known to this share by then [-]: a linear update over a wide prior bends it and what
  /// sees it.
  double known_depth = 0.1;
};

/// Linearity index of an inverse-depth landmark seen from the current pose: 4 sigma_d / d |cos(alpha)| [-],
/// with sigma_d the depth's standard deviation from the anchor, d the distance now, alpha the parallax.
[[nodiscard]] double linearity_index(const Estimate& estimate, const Landmark& landmark);

/// @brief How far the projection of a landmark departs from its linearisation over one standard deviation
/// [px]: standard deviation of the predicted left pixel times that of the relative depth, to second order.
/// Counts everything that pose, anchor and landmark share; infinite where the landmark does not project.
[[nodiscard]] double projection_curvature(const Estimate& estimate, const Landmark& landmark,
                                          const MountedCamera& cam0);

/// How far the inverse depth has moved since an initialisation under a doubtful calibration, as a share of
/// what was assumed then [-]; zero while it is not known better than that, and for all other landmarks.
[[nodiscard]] double depth_shift(const Estimate& estimate, const Landmark& landmark);

/// Standard deviation of an inverse depth as a share of it [-]; zero for a Cartesian landmark, infinite where
/// the inverse depth is not positive. For landmarks that are not passive.
[[nodiscard]] double depth_doubt(const Estimate& estimate, const Landmark& landmark);

/// @brief Forgets observed landmarks that are to be initialised anew: those that were absent for a while and
/// whose place has become too uncertain, those whose depth turned out to be another, and those whose depth
/// was guessed and is told now.
/// @param previous_ns  time of the frame before: landmarks seen then are not absent
/// @return number of removed landmarks
std::size_t forget_misplaced(Estimate& estimate, const StereoFrame& frame, std::int64_t previous_ns,
                             const MountedCamera& cam0, const MapManagementOptions& options);

/// @brief Every epoch_s makes landmarks passive that were not seen for a while; recalls at any time those
/// that `frame` sees.
/// @param previous_ns  time of the frame before
/// @param may_end      whether an epoch that is old enough may end in this frame, which costs as much as
///                     several others
void update_active_set(Estimate& estimate, const StereoFrame& frame, std::int64_t previous_ns,
                       const MapManagementOptions& options, bool may_end = true);

/// @brief A map that somebody hands over at t_ns: its landmarks that were not seen lately go passive, with
/// all of the work of it, so that the first frames take no longer than others.
void rest_unseen(Estimate& estimate, std::int64_t t_ns, const MapManagementOptions& options);

/// @brief Converts landmarks that became linear enough and removes those that broke a rule.
/// Only landmarks seen in `t_ns` are looked at for conversion.
/// @return number of removed landmarks
std::size_t manage_map(Estimate& estimate, std::int64_t t_ns, const MapManagementOptions& options);

}  // namespace limber
