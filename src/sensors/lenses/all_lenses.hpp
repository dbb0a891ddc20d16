// SPDX-License-Identifier: MIT
#pragma once

#include "sensors/lenses/equidistant.hpp"
#include "sensors/lenses/none.hpp"
#include "sensors/lenses/omni.hpp"
#include "sensors/lenses/radial_tangential.hpp"
#include "sensors/lenses/rational.hpp"

namespace limber::detail {

/// The Lens of a distortion in a call of std::visit.
template <typename Model>
using LensOf = Lens<std::decay_t<Model>>;

}  // namespace limber::detail
