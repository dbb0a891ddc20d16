// SPDX-License-Identifier: MIT
#include "limber/health/rig_movement.hpp"

#include <Eigen/QR>
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

/// The same in pixels, of each frame's points: sum of (first − their mean)ᵀ px (second − theirs).
double px_about(const FrameHalves& halves, const Vector& first, const Vector& second) {
  return halves.px_products - first.dot(halves.px_second) - halves.px_first.dot(second) +
         first.dot(halves.px * second);
}

/// What one plausible error of each parameter changes a depth straight ahead by, as a share of it.
RigParameters slope_per_error(const RigParameters& theta, double baselines) {
  return depth_slope(theta, baselines).cwiseProduct(plausible_error(theta.tail<3>().norm()));
}

}  // namespace

void FrameHalves::add(const Matrix& of_points, const Vector& of_first, const Vector& of_second) {
  frames += 1.0;
  first += of_first;
  second += of_second;
  products.noalias() += of_first * of_second.transpose();
  px += of_points;
  px_first.noalias() += of_points * of_first;
  px_second.noalias() += of_points * of_second;
  px_products += of_first.dot(of_points * of_second);
}

FrameHalves& FrameHalves::operator+=(const FrameHalves& other) {
  frames += other.frames;
  first += other.first;
  second += other.second;
  products += other.products;
  px += other.px;
  px_first += other.px_first;
  px_second += other.px_second;
  px_products += other.px_products;
  return *this;
}

void DepthHalves::add_stretch(const std::vector<Pair>& first, const std::vector<Pair>& second) {
  if (first.size() < 2) {
    return;
  }
  Pair sum_first = Pair::Zero(), sum_second = Pair::Zero();
  for (std::size_t k = 0; k < first.size(); ++k) {
    sum_first += first[k];
    sum_second += second[k];
    products += first[k] * second[k];
  }
  products -= sum_first * sum_second / static_cast<double>(first.size());
  degrees += static_cast<double>(first.size()) - 1.0;
}

DepthHalves& DepthHalves::operator+=(const DepthHalves& other) {
  degrees += other.degrees;
  products += other.products;
  px_squared += other.px_squared;
  points += other.points;
  return *this;
}

RigMovement movement_of(const std::vector<FrameHalves>& blocks, Eigen::Index vergence) {
  FrameHalves all;
  double count = 0.0;
  for (const FrameHalves& block : blocks) {
    all += block;
    count += block.frames > 0.0 ? 1.0 : 0.0;
  }
  if (count < kFewestBlocks) {
    return {{0.0, 0.0, std::numeric_limits<double>::infinity()}};
  }
  // The mean counts frames by what they know, too.
  const Eigen::CompleteOrthogonalDecomposition<Matrix> weights(all.px);
  const Vector first = weights.solve(all.px_first), second = weights.solve(all.px_second);
  const double mean = px_about(all, first, second) / all.frames;
  double squares = 0.0;
  for (const FrameHalves& block : blocks) {
    const double off = px_about(block, first, second) - block.frames * mean;
    squares += off * off;
  }
  const double reach = t_95(count - 1.0) * std::sqrt(squares * count / (count - 1.0)) / all.frames;
  const auto root = [](double square) { return std::sqrt(std::max(square, 0.0)); };
  RigMovement out{{root(mean), root(mean - reach), root(std::max(mean, 0.0) + reach)}};
  all.px.diagonal().cwiseProduct(about(all, first, second).diagonal()).maxCoeff(&out.axis);
  // Of vergence a frame alone says what its epipolar lines say: the place of the lens.
  out.axis = out.axis == NormalEquations::kLens ? vergence : out.axis;
  return out;
}

std::array<RigParameters, 2> depth_ways(const RigParameters& theta) {
  const RigParameters slope = slope_per_error(theta, Tolerance{}.baselines);
  std::array<RigParameters, 2> out{RigParameters::Zero(), RigParameters::Zero()};
  out[0].head<3>() = slope.head<3>().normalized();
  out[1].tail<3>() = slope.tail<3>().normalized();
  return out;
}

DepthMovement depth_movement_of(const std::vector<DepthHalves>& blocks, const RigParameters& theta,
                                double baselines) {
  using Pair = DepthHalves::Pair;
  DepthHalves all;
  double count = 0.0;
  for (const DepthHalves& block : blocks) {
    all += block;
    count += block.degrees > 0.0 ? 1.0 : 0.0;
  }
  if (count < kFewestBlocks) {
    return {{0.0, 0.0, std::numeric_limits<double>::infinity()}};
  }
  const Pair mean = all.products / all.degrees;
  const Pair explained = mean * all.px_squared / all.points;
  const Eigen::Index best = explained(0) >= explained(1) ? 0 : 1, other = 1 - best;
  // The better one and the other, and by how much it explains more, each with what blocks scatter by.
  Pair squares = Pair::Zero();
  double of_more = 0.0;
  for (const DepthHalves& block : blocks) {
    const Pair off = block.products - block.degrees * mean;
    const Pair off_px = off * all.px_squared / all.points;
    squares += off.square();
    of_more += (off_px(best) - off_px(other)) * (off_px(best) - off_px(other));
  }
  const double scale = t_95(count - 1.0) * std::sqrt(count / (count - 1.0)) / all.degrees;
  const Pair reach = scale * squares.sqrt();
  const bool certain = explained(best) - explained(other) > scale * std::sqrt(of_more);
  const std::array<RigParameters, 2> ways = depth_ways(theta);
  const RigParameters slope = slope_per_error(theta, baselines);
  const Pair share(std::abs(slope.dot(ways[0])), std::abs(slope.dot(ways[1])));
  const Pair size = share * mean.max(0.0).sqrt(), low = share * (mean - reach).max(0.0).sqrt(),
             high = share * (mean.max(0.0) + reach).sqrt();
  const Eigen::Index named = certain ? best : 0;
  DepthMovement out{
      {size(named), certain ? low(best) : low.minCoeff(), certain ? high(best) : high.maxCoeff()}};
  ways[static_cast<std::size_t>(named)].cwiseAbs().maxCoeff(&out.axis);
  return out;
}

}  // namespace limber
