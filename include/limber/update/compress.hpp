// SPDX-License-Identifier: MIT
#pragma once

#include "limber/core/linear_measurement.hpp"

namespace limber {

/// @brief An equivalent measurement with fewer rows: the same update, the same NIS.
///
/// A point that two cameras see has four rows, but only three unknowns of its own. An orthogonal change of
/// its rows leaves one that looks at nothing but what most points share; of a Cartesian point that is the
/// epipolar constraint, which looks at theta alone. There are as many such rows as points, while what they
/// look at has few dimensions (the epipolar geometry five): an orthogonal change of these rows leaves as
/// many, and the rest is noise alone.
/// @return whitened rows (sigma = 1), those of the shared unknowns last, without groups; or `z` as it is
/// where
///         hardly anything is to be gained
/// @note [MourikisRoumeliotis2007], sections III-D and III-E.
[[nodiscard]] LinearMeasurement compressed(const LinearMeasurement& z);

}  // namespace limber
