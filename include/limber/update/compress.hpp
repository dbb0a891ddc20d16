// SPDX-License-Identifier: MIT
#pragma once

#include "limber/core/linear_measurement.hpp"

namespace limber {

/// @brief An equivalent measurement with fewer rows: the same update, the same NIS.
///
/// A point that two cameras see has four rows, which depend on all states through three numbers: where it
/// stands in the body frame. An orthogonal change of its rows leaves one that no state moves; it is the
/// epipolar constraint, which looks at theta alone, unless theta is a state. There are as many such rows as
/// points, while what they look at has few dimensions (the epipolar geometry five): an orthogonal change of
/// these rows leaves as many, and the rest is noise alone.
/// @return whitened rows (sigma = 1) without groups: three a point; then, where theta is a state, the few
///         rows that see it alone; where it is not, those are the stateless rows. `z` as it is if no group
///         has four rows and a point of its own
/// @note [MourikisRoumeliotis2007], sections III-D and III-E.
[[nodiscard]] LinearMeasurement compressed(const LinearMeasurement& z);

}  // namespace limber
