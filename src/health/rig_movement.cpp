// SPDX-License-Identifier: MIT
#include "limber/health/rig_movement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limber {
namespace {

using Matrix = NormalEquations::Matrix;
using Vector = NormalEquations::Vector;

constexpr double kFewestBlocks = 3.0;
constexpr double kNormal95 = 1.96;

/// Two-sided 95 % of Student's t (Cornish-Fisher).
double t_95(double dof) {
  const double z = kNormal95, z3 = z * z * z, z5 = z3 * z * z;
  return z + (z3 + z) / (4.0 * dof) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * dof * dof);
}

/// Sum over the frames of (first − their mean) (second − theirs)ᵀ.
Matrix about(const FrameHalves& halves, const Vector& first, const Vector& second) {
  return halves.products - first * halves.second.transpose() - halves.first * second.transpose() +
         halves.frames * first * second.transpose();
}

}  // namespace

void FrameHalves::add(const Vector& of_first, const Vector& of_second) {
  frames += 1.0;
  first += of_first;
  second += of_second;
  products.noalias() += of_first * of_second.transpose();
}

FrameHalves& FrameHalves::operator+=(const FrameHalves& other) {
  frames += other.frames;
  first += other.first;
  second += other.second;
  products += other.products;
  return *this;
}

RigMovement movement_of(const std::vector<FrameHalves>& blocks, const Matrix& epipolar) {
  FrameHalves all;
  double count = 0.0;
  for (const FrameHalves& block : blocks) {
    all += block;
    count += block.frames > 0.0 ? 1.0 : 0.0;
  }
  if (count < kFewestBlocks) {
    return {{0.0, 0.0, std::numeric_limits<double>::infinity()}};
  }
  // Of vergence a frame alone says what its epipolar lines say: the place of the lens.
  Matrix px = epipolar;
  px.row(NormalEquations::kVergence).swap(px.row(NormalEquations::kLens));
  px.col(NormalEquations::kVergence).swap(px.col(NormalEquations::kLens));
  const Vector first = all.first / all.frames, second = all.second / all.frames;
  const Matrix covariance = about(all, first, second) / all.frames;
  const double mean = px.cwiseProduct(covariance).sum();
  double squares = 0.0;
  for (const FrameHalves& block : blocks) {
    const double off = px.cwiseProduct(about(block, first, second)).sum() - block.frames * mean;
    squares += off * off;
  }
  const double reach = t_95(count - 1.0) * std::sqrt(squares * count / (count - 1.0)) / all.frames;
  const auto root = [](double square) { return std::sqrt(std::max(square, 0.0)); };
  RigMovement out{{root(mean), root(mean - reach), root(std::max(mean, 0.0) + reach)}};
  px.diagonal().cwiseProduct(covariance.diagonal()).maxCoeff(&out.axis);
  out.axis = out.axis == NormalEquations::kLens ? NormalEquations::kVergence : out.axis;
  return out;
}

}  // namespace limber
