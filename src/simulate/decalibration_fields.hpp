// SPDX-License-Identifier: MIT
#pragma once

#include "field_visitor.hpp"
#include "limber/simulate/decalibration.hpp"

namespace limber::detail {

/// The fields of one entry of `decalibration`: its shape, what that has, and an amplitude, in which a length
/// may be a share of `baseline` [m].
void visit_signal(FieldVisitor& io, DecalibrationSignal& signal, double baseline);

}  // namespace limber::detail
