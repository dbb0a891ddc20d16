// SPDX-License-Identifier: MIT
#include "limber/health/normal_equations.hpp"

#include <cmath>

#include "limber/core/factors.hpp"

namespace limber {

NormalEquations::Vector NormalEquations::score(const Vector& beta) const {
  return vector - information * beta;
}

NormalEquations::Vector NormalEquations::solution() const { return Cholesky(information).inverse() * vector; }

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  information += other.information;
  vector += other.vector;
  return *this;
}

Eigen::Index vergence_axis(const RigParameters& theta) {
  return std::abs(theta(4)) > std::abs(theta(3)) ? 0 : 1;  // the baseline lies along y, or along x
}

}  // namespace limber
