// SPDX-License-Identifier: MIT
// Steps of biases and clock that are carried along, beside their slow twin: what a step does to the errors,
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
using testing::with_supposed_steps;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Steps = Estimate::Steps;
using L = StateLayout;

constexpr Index kOfBody = 15, kOfRows = 8, kClock = 6;
constexpr double kRowNoise = 0.05;

/// A filter of random predictions and updates, with all that a unit step of each bias and of the clock does
/// to its errors.
struct Twin {
  Estimate estimate;
  MatrixXd errors;  ///< per unit step: gyro, accelerometer, clock
  Matrix7 information = Matrix7::Zero();

  explicit Twin(Estimate map) : estimate(std::move(map)) {
    estimate.restart_bias_steps();
    estimate.restart_clock_step();
    errors = MatrixXd::Zero(estimate.size(), 7);
    errors.middleRows<6>(L::kBiasGyro).setIdentity();
    errors.middleRows<7>(estimate.layout().supposed_steps()).setIdentity();
  }

  void predict(Generator& generator) {
    const MatrixXd Phi =
        MatrixXd::Identity(kOfBody, kOfBody) + 0.1 * random_matrix(generator, kOfBody, kOfBody);
    estimate.mutable_P().propagate_leading(Phi, 1e-4 * MatrixXd::Identity(kOfBody, kOfBody));
    errors.topRows<kOfBody>() = (Phi * errors.topRows<kOfBody>()).eval();
    const Eigen::Matrix<double, kOfBody, 1> by_clock = random_matrix(generator, kOfBody, 1);
    estimate.move_with_clock_step(by_clock);
    errors.topRows<kOfBody>() += by_clock * errors.row(estimate.layout().clock_step());
  }

  /// Innovations are those of the steps alone.
  void update(Generator& generator, const Steps& steps) {
    MatrixXd H = random_matrix(generator, kOfRows, estimate.size());
    H.middleCols<9>(estimate.layout().supposed_steps()).setZero();
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

Twin after_some_frames(std::uint64_t seed, const Steps& steps) {
  Generator generator(seed);
  Twin twin(random_map(generator, 6, with_supposed_steps()));
  for (int frame = 0; frame < 4; ++frame) {
    twin.predict(generator);
    twin.update(generator, steps);
  }
  return twin;
}

TEST(SupposedSteps, OpensAllThatAStepDid) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Twin twin = after_some_frames(seed, Steps::Zero());
    Steps sigma;
    sigma << 0.01, 0.02, 0.03, 0.3, 0.2, 0.1, 0.05;
    const MatrixXd before = twin.estimate.P().dense();
    twin.estimate.suppose_steps(sigma);
    const MatrixXd opened = twin.errors * sigma.asDiagonal();
    const MatrixXd expected = opened * opened.transpose();
    EXPECT_LE((twin.estimate.P().dense() - before - expected).norm(), 1e-6 * expected.norm());
  }
}

TEST(SupposedSteps, KnowsTheStepThatInnovationsShow) {
  Steps steps;  // small: errors are linear in them
  steps << 1e-5, -2e-5, 3e-5, 2e-5, -1e-5, 3e-5, -2e-5;
  for (const std::uint64_t seed : {4U, 5U, 6U}) {
    const Twin twin = after_some_frames(seed, steps);
    const Estimate::SupposedSteps found = twin.estimate.supposed_steps();
    EXPECT_LE((found.information - twin.information).norm(), 1e-3 * twin.information.norm());
    const Steps best = found.information.ldlt().solve(found.evidence);
    EXPECT_LE((best - steps).norm(), 0.02 * steps.norm());
  }
}

TEST(SupposedSteps, IsTooSmallToBeNoticed) {
  Generator generator(7), again(7);
  const Estimate without = random_map(generator, 6), with = random_map(again, 6, with_supposed_steps());
  const auto of_body = [](const Estimate& estimate) { return estimate.P().block(0, 0, kOfBody, kOfBody); };
  EXPECT_LE((of_body(with) - of_body(without)).cwiseAbs().maxCoeff(), 1.1e-10);  // of 1e-4
}

TEST(SupposedSteps, ARestartForgetsWhatWasBefore) {
  Twin twin = after_some_frames(8, Steps::Constant(1e-5));
  twin.estimate.restart_bias_steps();
  twin.estimate.restart_clock_step();
  const Estimate::SupposedSteps found = twin.estimate.supposed_steps();
  EXPECT_LE(found.evidence.norm(), 1e-9);
  EXPECT_LE(found.information.norm(), 1e-4 * twin.information.norm());  // rounding, over a tiny square
  const MatrixXd before = twin.estimate.P().dense();
  twin.estimate.suppose_steps(Steps::Constant(0.1));
  MatrixXd opened = MatrixXd::Zero(before.rows(), 7);
  opened.middleRows<6>(L::kBiasGyro).diagonal().setConstant(0.1);
  opened.middleRows<7>(twin.estimate.layout().supposed_steps()).diagonal().setConstant(0.1);
  EXPECT_LE((twin.estimate.P().dense() - before - opened * opened.transpose()).norm(), 1e-9);
}

/// The biases' part of what is known goes; the clock's stays as it is.
TEST(SupposedSteps, ARestartOfTheBiasesLeavesTheClock) {
  Twin twin = after_some_frames(9, Steps::Constant(1e-5));
  const Estimate::SupposedSteps before = twin.estimate.supposed_steps();
  twin.estimate.restart_bias_steps();
  const Estimate::SupposedSteps after = twin.estimate.supposed_steps();
  EXPECT_NEAR(after.information(kClock, kClock) / before.information(kClock, kClock), 1.0, 1e-3);
  const Eigen::Matrix<double, 6, 6> of_biases = after.information.topLeftCorner<6, 6>();
  EXPECT_LE(of_biases.norm(), 1e-4 * before.information.norm());
  EXPECT_LE(after.evidence.head<6>().norm(), 1e-6 * before.evidence.norm());
}

/// Opened, the clock is a state like any other: later innovations tell its step, and the supposed ones of the
/// biases are those beside it.
TEST(SupposedSteps, AClockThatIsOpenIsEstimated) {
  Steps steps = Steps::Zero();
  steps(kClock) = 1e-4;
  Generator generator(10);
  Twin twin = after_some_frames(11, Steps::Zero());
  twin.estimate.restart_clock_step();  // it steps now
  twin.errors.col(kClock).setZero();
  twin.errors(twin.estimate.layout().clock_step(), kClock) = 1.0;
  twin.estimate.open_clock_step(0.01);
  EXPECT_NEAR(twin.estimate.clock_step().sigma, 0.01, 1e-4);
  for (int frame = 0; frame < 20; ++frame) {
    twin.predict(generator);
    twin.update(generator, steps);
  }
  const Estimate::ClockStep found = twin.estimate.clock_step();
  EXPECT_LE(found.sigma, 3e-3);
  EXPECT_NEAR(found.mean, steps(kClock), 0.2 * steps(kClock));
  EXPECT_EQ(twin.estimate.supposed_steps().information.col(kClock).norm(), 0.0);
  EXPECT_EQ(twin.estimate.supposed_steps().evidence(kClock), 0.0);
  twin.estimate.restart_clock_step();
  EXPECT_LE(twin.estimate.clock_step().sigma, 2e-6);
}

}  // namespace
}  // namespace limber
