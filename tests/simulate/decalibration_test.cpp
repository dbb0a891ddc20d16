// SPDX-License-Identifier: MIT
#include "limber/simulate/decalibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace limber {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr double kDuration = 35.0;

RigParameters ones() { return RigParameters::Ones(); }

/// What a shape is worth at an instant (amplitude 1, third parameter).
double value(const DecalibrationShape& shape, std::int64_t t_ns) {
  return Decalibration({{ones(), shape}}, kDuration, 1, 0).at(t_ns)[2];
}

TEST(Decalibration, IsZeroWithoutSignals) {
  EXPECT_TRUE(Decalibration({}, kDuration, 1, 0).at(5 * kSecond).isZero(0.0));
}

TEST(Decalibration, TakesThePapersDeltaInRadiansAndMetres) {
  const RigParameters delta = paper_decalibration();
  EXPECT_NEAR(delta[0], 1.7453292519943295e-4, 1e-18);
  EXPECT_NEAR(delta[1], -8.726646259971648e-4, 1e-17);
  EXPECT_NEAR(delta[2], 1.7453292519943295e-3, 1e-17);
  EXPECT_EQ(delta.tail<3>(), Eigen::Vector3d(0.1, -0.01, 0.005));
}

TEST(Decalibration, ScalesEveryParameterByTheShape) {
  const Decalibration steps({{paper_decalibration(), StepsShape{}}}, kDuration, 1, 0);
  EXPECT_EQ(steps.at(10 * kSecond), paper_decalibration());
  EXPECT_EQ(steps.at(30 * kSecond), -paper_decalibration());
}

TEST(Decalibration, AddsItsSignals) {
  const Decalibration both({{ones(), ConstantShape{}}, {2.0 * ones(), StepsShape{}}}, kDuration, 1, 0);
  EXPECT_EQ(both.at(0), ones());
  EXPECT_EQ(both.at(12 * kSecond), 3.0 * ones());
}

TEST(SinusShape, IsTheSineOfTime) {
  EXPECT_NEAR(value(SinusShape{}, 1'500'000'000), std::sin(1.5), 1e-15);
  EXPECT_NEAR(value(SinusShape{3.0, 0.5}, 2 * kSecond), std::sin(6.5), 1e-14);
}

TEST(StepsShape, ChangesAtEachInstantAndNotBefore) {
  const StepsShape steps;  // +1 at 10 s, back to 0 at 20 s, -1 at 27 s
  EXPECT_EQ(value(steps, 0), 0.0);
  EXPECT_EQ(value(steps, 10 * kSecond - 1), 0.0);
  EXPECT_EQ(value(steps, 10 * kSecond), 1.0);
  EXPECT_EQ(value(steps, 20 * kSecond - 1), 1.0);
  EXPECT_EQ(value(steps, 20 * kSecond), 0.0);
  EXPECT_EQ(value(steps, 27 * kSecond), -1.0);
  EXPECT_EQ(value(steps, 35 * kSecond), -1.0);
}

TEST(SquareWaveShape, IsCentredAndStartsWithItsUpperHalf) {
  const SquareWaveShape wave;
  EXPECT_EQ(value(wave, 0), 1.0);
  EXPECT_EQ(value(wave, kSecond / 2 - 1), 1.0);
  EXPECT_EQ(value(wave, kSecond / 2), -1.0);
  EXPECT_EQ(value(wave, kSecond - 1), -1.0);
  EXPECT_EQ(value(wave, 34 * kSecond), 1.0);
  double sum = 0.0;
  for (std::int64_t j = 0; j < 700; ++j) {  // the frames of the paper
    sum += value(wave, j * 50'000'000);
  }
  EXPECT_EQ(sum, 0.0);
}

TEST(RampShape, IsLinearBetweenItsEndsAndFlatOutside) {
  const RampShape ramp{5.0, 15.0};
  EXPECT_EQ(value(ramp, 5 * kSecond), 0.0);
  EXPECT_NEAR(value(ramp, 8 * kSecond), 0.3, 1e-15);
  EXPECT_EQ(value(ramp, 20 * kSecond), 1.0);
}

// 400 walks of 6 parameters: five standard deviations of an estimated variance.
TEST(RandomWalkShape, SpreadsWithTheSquareRootOfTime) {
  double variance = 0.0, increment = 0.0, mixed = 0.0;
  constexpr int kWalks = 400, kValues = 6 * kWalks;
  for (std::uint64_t run = 0; run < kWalks; ++run) {
    const Decalibration walk({{ones(), RandomWalkShape{0.5}}}, kDuration, 1, run);
    const RigParameters at_10 = walk.at(10 * kSecond), at_19 = walk.at(19 * kSecond);
    EXPECT_TRUE(walk.at(0).isZero(0.0));
    variance += at_10.squaredNorm() / kValues;
    increment += (at_19 - at_10).squaredNorm() / kValues;
    mixed += at_10[0] * at_10[3] / kWalks;
  }
  EXPECT_NEAR(variance, 0.25 * 10.0, 2.5 * 5.0 * std::sqrt(2.0 / kValues));
  EXPECT_NEAR(increment, 0.25 * 9.0, 2.25 * 5.0 * std::sqrt(2.0 / kValues));
  EXPECT_NEAR(mixed, 0.0, 2.5 * 5.0 / std::sqrt(kWalks));
}

TEST(RandomWalkShape, IsContinuousAndOneFunctionOfTime) {
  const Decalibration walk({{ones(), RandomWalkShape{}}}, kDuration, 1, 0);
  for (std::int64_t t = 1; t < 35 * kSecond; t += 123'456'789) {
    EXPECT_LT((walk.at(t) - walk.at(t - 1)).norm(), 1e-6);
    EXPECT_EQ(walk.at(t), walk.at(t));
  }
}

// 2000 draws of 6 parameters.
TEST(WhiteNoiseShape, IsFreshAtEveryInstantAndTheSameWhenAskedAgain) {
  const Decalibration noise({{2.0 * ones(), WhiteNoiseShape{}}}, kDuration, 1, 0);
  double variance = 0.0, neighbours = 0.0;
  constexpr int kDraws = 2000;
  for (std::int64_t j = 0; j < kDraws; ++j) {
    const RigParameters now = noise.at(j * 50'000'000);
    EXPECT_EQ(now, noise.at(j * 50'000'000));
    variance += now.squaredNorm() / (6 * kDraws);
    neighbours += now.dot(noise.at((j + 1) * 50'000'000)) / (6 * kDraws);
  }
  EXPECT_NEAR(variance, 4.0, 4.0 * 5.0 * std::sqrt(2.0 / (6 * kDraws)));
  EXPECT_NEAR(neighbours, 0.0, 4.0 * 5.0 / std::sqrt(6.0 * kDraws));
}

TEST(Decalibration, KeepsTheDrawsOfASignalWhenALaterOneIsAdded) {
  const DecalibrationSignal walk{ones(), RandomWalkShape{}}, constant{ones(), ConstantShape{}};
  const Decalibration alone({walk}, kDuration, 1, 0), both({walk, constant}, kDuration, 1, 0);
  EXPECT_TRUE((both.at(7 * kSecond) - alone.at(7 * kSecond) - ones()).isZero(1e-14));
}

TEST(Decalibration, NamesEveryInstantAtWhichItJumps) {
  const Decalibration smooth({{ones(), SinusShape{}}, {ones(), RampShape{1.0, 2.0}}}, kDuration, 1, 0);
  EXPECT_TRUE(smooth.jumps(35 * kSecond).empty());

  const Decalibration jumping({{ones(), StepsShape{}}, {ones(), SquareWaveShape{10.0}}}, kDuration, 1, 0);
  const std::vector<std::int64_t> jumps = jumping.jumps(22 * kSecond);
  EXPECT_EQ(jumps, (std::vector<std::int64_t>{5 * kSecond, 10 * kSecond, 15 * kSecond, 20 * kSecond}));
  for (const std::int64_t t : jumps) {
    EXPECT_GT((jumping.at(t) - jumping.at(t - 1)).norm(), 0.5);
  }
}

TEST(Decalibration, RefusesShapesThatMakeNoSense) {
  const auto make = [](const DecalibrationShape& shape) {
    return Decalibration({{ones(), shape}}, kDuration, 1, 0);
  };
  EXPECT_THROW(make(StepsShape{{{5.0, 1.0}, {5.0, 2.0}}}), std::invalid_argument);
  EXPECT_THROW(make(SquareWaveShape{0.0}), std::invalid_argument);
  EXPECT_THROW(make(RampShape{3.0, 3.0}), std::invalid_argument);
  EXPECT_THROW(make(RandomWalkShape{-1.0}), std::invalid_argument);
  EXPECT_THROW(make(SinusShape{std::nan(""), 0.0}), std::invalid_argument);
  EXPECT_THROW(Decalibration({{ones() * HUGE_VAL, ConstantShape{}}}, kDuration, 1, 0), std::invalid_argument);
  EXPECT_THROW(Decalibration({}, -1.0, 1, 0), std::invalid_argument);
  EXPECT_THROW((void)make(ConstantShape{}).at(-1), std::invalid_argument);
}

}  // namespace
}  // namespace limber
