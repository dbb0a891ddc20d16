// SPDX-License-Identifier: MIT
#include "limber/health/normal_equations.hpp"

namespace limber {

NormalEquations::Vector NormalEquations::score(const Vector& beta) const {
  return vector - information * beta;
}

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  information += other.information;
  vector += other.vector;
  return *this;
}

}  // namespace limber
