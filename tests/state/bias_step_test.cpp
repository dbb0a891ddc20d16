// SPDX-License-Identifier: MIT
// Steps of the biases that are carried along, beside their slow twin: what a step does to the errors,
// followed by itself.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "limber/state/estimate.hpp"
#include "random_matrix.hpp"
#include "small_map.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using testing::Generator;
using testing::random_map;
using testing::random_matrix;
using testing::with_bias_step;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using L = StateLayout;

constexpr Index kOfBody = 15, kOfRows = 8;
constexpr double kRowNoise = 0.05;

/// A filter of random predictions and updates, with all that a unit step of each bias does to its errors.
struct Twin {
  Estimate estimate;
  MatrixXd errors;  ///< per unit step: gyro, accelerometer
  Matrix6 information = Matrix6::Zero();

  explicit Twin(Estimate map) : estimate(std::move(map)) {
    estimate.restart_bias_step();
    errors = MatrixXd::Zero(estimate.size(), 6);
    errors.middleRows<6>(L::kBiasGyro).setIdentity();
    errors.middleRows<6>(estimate.layout().bias_step()).setIdentity();
  }

  void predict(Generator& generator) {
    const MatrixXd Phi =
        MatrixXd::Identity(kOfBody, kOfBody) + 0.1 * random_matrix(generator, kOfBody, kOfBody);
    estimate.mutable_P().propagate_leading(Phi, 1e-4 * MatrixXd::Identity(kOfBody, kOfBody));
    errors.topRows<kOfBody>() = (Phi * errors.topRows<kOfBody>()).eval();
  }

  /// Innovations are those of the steps alone.
  void update(Generator& generator, const Vector6& steps) {
    MatrixXd H = random_matrix(generator, kOfRows, estimate.size());
    H.middleCols<6>(estimate.layout().bias_step()).setZero();
    const MatrixXd PHt = estimate.P().times(H.transpose());
    const MatrixXd S = H * PHt + kRowNoise * kRowNoise * MatrixXd::Identity(kOfRows, kOfRows);
    const MatrixXd K = PHt * S.inverse(), G = H * errors;
    information += G.transpose() * S.inverse() * G;
    errors -= K * G;
    const MatrixXd lower = S.llt().matrixL();
    estimate.mutable_P().subtract_outer(
        lower.triangularView<Eigen::Lower>().solve(PHt.transpose()).transpose());
    estimate.retract(K * (G * steps));
  }
};

Twin after_some_frames(std::uint64_t seed, const Vector6& steps) {
  Generator generator(seed);
  Twin twin(random_map(generator, 6, with_bias_step()));
  for (int frame = 0; frame < 4; ++frame) {
    twin.predict(generator);
    twin.update(generator, steps);
  }
  return twin;
}

TEST(BiasStep, OpensAllThatAStepDid) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Twin twin = after_some_frames(seed, Vector6::Zero());
    Vector6 sigma;
    sigma << 0.01, 0.02, 0.03, 0.3, 0.2, 0.1;
    const MatrixXd before = twin.estimate.P().dense();
    twin.estimate.suppose_bias_step(sigma);
    const MatrixXd opened = twin.errors * sigma.asDiagonal();
    const MatrixXd expected = opened * opened.transpose();
    EXPECT_LE((twin.estimate.P().dense() - before - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(BiasStep, KnowsTheStepThatInnovationsShow) {
  Vector6 steps;  // small: errors are linear in them
  steps << 1e-5, -2e-5, 3e-5, 2e-5, -1e-5, 3e-5;
  for (const std::uint64_t seed : {4U, 5U, 6U}) {
    const Twin twin = after_some_frames(seed, steps);
    const Estimate::BiasStep found = twin.estimate.bias_step();
    EXPECT_LE((found.information - twin.information).norm(), 1e-3 * twin.information.norm());
    const Vector6 best = found.information.ldlt().solve(found.evidence);
    EXPECT_LE((best - steps).norm(), 0.02 * steps.norm());
  }
}

TEST(BiasStep, IsTooSmallToBeNoticed) {
  Generator generator(7), again(7);
  const Estimate without = random_map(generator, 6), with = random_map(again, 6, with_bias_step());
  const auto of_body = [](const Estimate& estimate) { return estimate.P().block(0, 0, kOfBody, kOfBody); };
  EXPECT_LE((of_body(with) - of_body(without)).cwiseAbs().maxCoeff(), 1.1e-10);  // of 1e-4
}

TEST(BiasStep, ARestartForgetsWhatWasBefore) {
  Twin twin = after_some_frames(8, Vector6::Constant(1e-5));
  twin.estimate.restart_bias_step();
  const Estimate::BiasStep found = twin.estimate.bias_step();
  EXPECT_LE(found.evidence.norm(), 1e-9);
  EXPECT_LE(found.information.norm(), 1e-4 * twin.information.norm());  // rounding, over a tiny square
  const MatrixXd before = twin.estimate.P().dense();
  twin.estimate.suppose_bias_step(Vector6::Constant(0.1));
  MatrixXd opened = MatrixXd::Zero(before.rows(), 6);
  opened.middleRows<6>(L::kBiasGyro).diagonal().setConstant(0.1);
  opened.middleRows<6>(twin.estimate.layout().bias_step()).diagonal().setConstant(0.1);
  EXPECT_LE((twin.estimate.P().dense() - before - opened * opened.transpose()).norm(), 1e-9);
}

}  // namespace
}  // namespace limber
