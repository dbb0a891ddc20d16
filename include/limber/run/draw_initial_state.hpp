// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "limber/sensors/samples.hpp"
#include "limber/state/initial_sigma.hpp"

namespace limber {

/// @brief A state that an estimator may start from: the truth plus an error drawn from `sigmas`,
/// R = R_true Exp(dtheta) and sums otherwise.
[[nodiscard]] GroundTruthState draw_initial_state(const GroundTruthState& truth, const InitialSigma& sigmas,
                                                  std::uint64_t seed, std::uint64_t run = 0);

}  // namespace limber
