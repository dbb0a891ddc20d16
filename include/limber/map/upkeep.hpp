// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "limber/map/estimate.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// Rules that keep the map small and well behaved.
struct UpkeepOptions {
  std::size_t max_landmarks = 300;  ///< beyond it, those unseen for longest go
  double forget_after_s = 1e9;  ///< unseen for longer: gone (tracks of an image front end never come back)
  int max_refusals = 3;         ///< refused by the gate in this many frames in a row: gone
  /// Inverse-depth landmarks become Cartesian when the linearity index of [Civera2008], Eq. (30) falls below.
  double linearity_index = 0.1;
};

/// Linearity index of an inverse-depth landmark seen from the current pose: 4 sigma_d / d |cos(alpha)| [-],
/// with sigma_d the depth's standard deviation from the anchor, d the distance now, alpha the parallax.
[[nodiscard]] double linearity_index(const Estimate& estimate, const Landmark& landmark);

/// @brief Converts landmarks that became linear enough and removes those that broke a rule.
/// Only landmarks seen in `t_ns` are looked at for conversion.
/// @return number of removed landmarks
std::size_t keep_up(Estimate& estimate, std::int64_t t_ns, const UpkeepOptions& options);

}  // namespace limber
