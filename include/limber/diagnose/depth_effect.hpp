// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "limber/health/robust_estimate.hpp"

namespace limber {

/// What a wrong calibration makes of a depth that the two cameras measure.
struct DepthEffect {
  double depth = 0.0;           ///< true depth [m]
  std::optional<double> error;  ///< measured minus true [m]; nothing where the rays no longer meet in front
  double sigma = 0.0;           ///< of the error, from the covariance of the offset [m]
};

/// Where the effect is shown [m].
inline constexpr std::array kShownDepths = {5.0, 10.0, 20.0};

/// @brief Measured minus true depth of a point straight ahead of cam0: seen by the true rig (assumed +
/// delta), triangulated with the assumed one.
/// @param depth  > 0 [m]
[[nodiscard]] std::optional<double> depth_error(const RigParameters& assumed, const RigParameters& delta,
                                                double depth);

/// The effect at kShownDepths; sigma to first order.
/// @param metric  whether something shows how long a metre is: else the length of the baseline is trusted, as
///                by the verdict
[[nodiscard]] std::vector<DepthEffect> depth_effects(const RigParameters& assumed, const RigEstimate& offset,
                                                     bool metric);

}  // namespace limber
