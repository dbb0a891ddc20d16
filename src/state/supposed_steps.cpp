// SPDX-License-Identifier: MIT
// Estimate's steps of an IMU: what they would do, carried along. docs/derivations/faults.md
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "limber/core/so3.hpp"
#include "limber/state/estimate.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using L = StateLayout;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

namespace {

/// Of the steps that are carried along, far below what a bias walks by: no gain notices them.
constexpr double kGyro = 1e-7, kAccel = 1e-5, kClock = 1e-6;  // [rad/s], [m/s^2], [s]

Estimate::Steps supposed_sigma() {
  Estimate::Steps out;
  out << kGyro, kGyro, kGyro, kAccel, kAccel, kAccel, kClock;
  return out;
}

}  // namespace

void Estimate::restart_bias_steps() {
  static_assert(L::kBiasAccel == L::kBiasGyro + kTriplet);
  const Matrix6 variance = supposed_sigma().head<6>().cwiseAbs2().asDiagonal();
  MatrixXd columns = MatrixXd::Zero(size(), 6);
  columns.middleRows<6>(layout_.supposed_steps()) = variance;
  columns.middleRows<6>(L::kBiasGyro) = variance;
  P_.scatter(std::array{layout_.supposed_steps(), layout_.supposed_steps() + kTriplet}, columns);
  P_.set_diagonal_block(L::kBiasGyro, P_.diagonal_block<6>(L::kBiasGyro) + variance);
  steps_.head<6>().setZero();
}

void Estimate::restart_clock_step() {
  const Index at = layout_.clock_step();
  MatrixXd columns = MatrixXd::Zero(size(), kTriplet);
  columns.middleRows<kTriplet>(at) = kClock * kClock * Eigen::Matrix3d::Identity();
  P_.scatter(std::array{at}, columns);
  steps_(6) = 0.0;
}

void Estimate::open_clock_step(double sigma) {
  const Index at = layout_.clock_step();
  const Eigen::Vector3d variance(sigma * sigma, 0.0, 0.0);
  P_.set_diagonal_block(at, P_.diagonal_block<kTriplet>(at) + Eigen::Matrix3d(variance.asDiagonal()));
}

Estimate::ClockStep Estimate::clock_step() const {
  return {steps_(6), std::sqrt(P_.diagonal_block<kTriplet>(layout_.clock_step())(0, 0))};
}

void Estimate::move_with_clock_step(const Eigen::Matrix<double, 15, 1>& by) {
  Eigen::Matrix<double, 15, kTriplet> U = Eigen::Matrix<double, 15, kTriplet>::Zero();
  U.col(0) = by;
  P_.couple_leading(U, layout_.clock_step());
  nav_ = moved_with_clock_step(nav_, by);
}

NavigationState Estimate::moved_with_clock_step(NavigationState nav,
                                                const Eigen::Matrix<double, 15, 1>& by) const {
  const Eigen::Matrix<double, 15, 1> moved = steps_(6) * by;
  nav.T_world_body.p += moved.segment<3>(L::kPosition);
  nav.T_world_body.R = so3_normalized(nav.T_world_body.R * so3_exp(moved.segment<3>(L::kAttitude)));
  nav.v_world_body += moved.segment<3>(L::kVelocity);
  return nav;
}

Estimate::SupposedSteps Estimate::supposed_steps() const {
  const bool clock_is_open = clock_step().sigma > 2.0 * kClock;
  const Index n = clock_is_open ? 6 : 7;
  const Eigen::VectorXd weight = supposed_sigma().cwiseInverse().head(n);
  const MatrixXd of_unit = weight.asDiagonal() *
                           P_.diagonal_block<7>(layout_.supposed_steps()).topLeftCorner(n, n) *
                           weight.asDiagonal();
  const MatrixXd inverse = of_unit.inverse();
  SupposedSteps out{Matrix7::Zero(), Steps::Zero()};
  out.information.topLeftCorner(n, n) =
      weight.asDiagonal() * (inverse - MatrixXd::Identity(n, n)) * weight.asDiagonal();
  out.evidence.head(n) = weight.cwiseProduct(inverse * weight.cwiseProduct(steps_.head(n)));
  return out;
}

void Estimate::suppose_steps(const Steps& sigma) {
  MatrixXd columns;
  const Index first = layout_.supposed_steps();
  P_.gather(std::array{first, first + kTriplet, first + 2 * kTriplet}, columns);
  const Matrix7 variance = columns.block<7, 7>(first, 0);
  P_.add_outer(columns.leftCols<7>() * (variance.inverse() * sigma.asDiagonal()));
}

}  // namespace limber
