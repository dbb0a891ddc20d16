// SPDX-License-Identifier: MIT
#pragma once

#include "field_visitor.hpp"
#include "limber/simulate/scenario.hpp"

namespace limber::detail {

/// The fields of `rig`: theta, where the body is, and the two cameras.
void visit_rig(FieldVisitor& io, RigScenario& rig);

}  // namespace limber::detail
