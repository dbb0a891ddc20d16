// SPDX-License-Identifier: MIT
#pragma once

#include "field_visitor.hpp"
#include "limber/simulate/fault.hpp"

namespace limber::detail {

/// The fields of one entry of `faults`: its kind, and what that kind has.
void visit_fault(FieldVisitor& io, Fault& fault);

}  // namespace limber::detail
