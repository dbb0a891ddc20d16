// SPDX-License-Identifier: MIT
// Estimate's steps of the biases: what they would do, carried along. docs/derivations/faults.md
#include <Eigen/LU>
#include <array>

#include "limber/state/estimate.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using L = StateLayout;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

namespace {

/// Of the steps that are carried along, far below what a bias walks by: no gain notices them.
constexpr double kGyro = 1e-7, kAccel = 1e-5;  // [rad/s], [m/s^2]

Vector6 supposed_sigma() {
  Vector6 out;
  out << kGyro, kGyro, kGyro, kAccel, kAccel, kAccel;
  return out;
}

std::array<Index, 2> triplets(const StateLayout& layout) {
  return {layout.bias_step(), layout.bias_step() + kTriplet};
}

}  // namespace

void Estimate::restart_bias_step() {
  static_assert(L::kBiasAccel == L::kBiasGyro + kTriplet);
  const Matrix6 variance = supposed_sigma().cwiseAbs2().asDiagonal();
  MatrixXd columns = MatrixXd::Zero(size(), 6);
  columns.middleRows<6>(layout_.bias_step()) = variance;
  columns.middleRows<6>(L::kBiasGyro) = variance;
  P_.scatter(triplets(layout_), columns);
  P_.set_diagonal_block(L::kBiasGyro, P_.diagonal_block<6>(L::kBiasGyro) + variance);
  bias_step_.setZero();
}

Estimate::BiasStep Estimate::bias_step() const {
  const Vector6 weight = supposed_sigma().cwiseInverse();
  const Matrix6 of_unit =
      weight.asDiagonal() * P_.diagonal_block<6>(layout_.bias_step()) * weight.asDiagonal();
  const Matrix6 inverse = of_unit.inverse();
  return {weight.asDiagonal() * (inverse - Matrix6::Identity()) * weight.asDiagonal(),
          weight.cwiseProduct(inverse * weight.cwiseProduct(bias_step_))};
}

void Estimate::suppose_bias_step(const Vector6& sigma) {
  MatrixXd columns;
  P_.gather(triplets(layout_), columns);
  const Matrix6 variance = columns.middleRows<6>(layout_.bias_step());
  P_.add_outer(columns * (variance.inverse() * sigma.asDiagonal()));
}

}  // namespace limber
