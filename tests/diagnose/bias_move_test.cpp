// SPDX-License-Identifier: MIT
#include "limber/diagnose/bias_move.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

namespace limber {
namespace {

constexpr double kSigma = 1e-3;  // [rad/s]

/// Thirty seconds of twenty rows each, and their frames.
struct BiasRun {
  std::vector<TrajectoryRow> rows{600};
  std::vector<FrameReport> frames{600};

  /// @param bias  of the gyroscope's y axis at a time [s], in its sigmas
  explicit BiasRun(const std::function<double(double)>& bias) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const double t = 0.05 * static_cast<double>(k);
      rows[k].t_ns = frames[k].t_ns = static_cast<std::int64_t>(k) * 50'000'000;
      rows[k].bias_gyro = Eigen::Vector3d(0.0, kSigma * bias(t), 0.0);
      rows[k].bias_accel = Eigen::Vector3d::Zero();
      rows[k].sigma_bias_gyro = Eigen::Vector3d::Constant(kSigma);
      rows[k].sigma_bias_accel = Eigen::Vector3d::Constant(0.01);
    }
  }

  [[nodiscard]] std::optional<BiasMove> move() const { return bias_beyond_its_sigma(rows, frames); }
  void contradict_at(std::size_t row) { frames[row].inputs.status = InputStatus::kContradicted; }
  [[nodiscard]] std::optional<std::int64_t> impossible() const { return impossible_bias_since(rows); }
};

/// From zero to `sigmas` within two seconds from 15 s on.
BiasRun stepped(double sigmas) {
  return BiasRun([=](double t) { return sigmas * std::clamp(0.5 * (t - 15.0), 0.0, 1.0); });
}

TEST(BiasMove, IsSeenWhereABiasMovesByMoreThanItsSigmasAllow) {
  const auto move = stepped(30.0).move();
  ASSERT_TRUE(move);
  EXPECT_TRUE(move->is_sudden());
  EXPECT_TRUE(move->of_gyro);
  EXPECT_NEAR(1e-9 * static_cast<double>(move->to_ns), 15.8, 0.11);
  EXPECT_GE(1e-9 * static_cast<double>(move->from_ns), 14.7);
  EXPECT_GT(move->sigmas, 12.0);
  EXPECT_NEAR(move->size, move->sigmas * kSigma, 1e-9);
  EXPECT_FALSE(stepped(11.9).move());
}

TEST(BiasMove, IsNoneWhereTheFilterSaidThatItDoesNotKnowTheBias) {
  BiasRun run = stepped(30.0);
  for (std::size_t k = 299; k < 400; ++k) {
    run.rows[k].sigma_bias_gyro = Eigen::Vector3d::Constant(20.0 * kSigma);
  }
  EXPECT_FALSE(run.move());
}

TEST(BiasMove, IsExcusedByAContradictionBesideItAndNotSuddenAfterOne) {
  BiasRun during = stepped(30.0), long_before = stepped(30.0);
  during.contradict_at(340);
  EXPECT_FALSE(during.move());
  long_before.contradict_at(200);
  ASSERT_TRUE(long_before.move());
  EXPECT_FALSE(long_before.move()->is_sudden()) << "the filter has said that something failed";
}

/// Sigmas that are too small all along are no fault that begins.
TEST(BiasMove, IsNotSuddenWhereBiasesMoveAllAlong) {
  const auto move = BiasRun([](double t) { return 20.0 * std::sin(0.7 * t); }).move();
  ASSERT_TRUE(move);
  EXPECT_FALSE(move->is_sudden());
  EXPECT_GT(move->usual_sigmas, 4.0);
  const auto worse = BiasRun([](double t) { return 20.0 * std::sin(0.7 * t) + (t > 20.0 ? 500.0 : 0.0); });
  EXPECT_TRUE(worse.move()->is_sudden());
  EXPECT_NEAR(1e-9 * static_cast<double>(worse.move()->to_ns), 20.05, 0.1);
}

TEST(BiasMove, PassesOverRowsThatKnowNoBias) {
  BiasRun run = stepped(30.0);
  for (std::size_t k = 0; k < 40; ++k) run.rows[k].sigma_bias_gyro.reset();
  EXPECT_TRUE(run.move());
  for (TrajectoryRow& row : run.rows) row.bias_gyro.reset();
  EXPECT_FALSE(run.move());
  EXPECT_FALSE(bias_beyond_its_sigma({}, {}));
  EXPECT_THROW((void)bias_beyond_its_sigma(run.rows, {}), std::invalid_argument);
}

TEST(ImpossibleBias, IsOneThatNoSensorHasForASecond) {
  BiasRun run = stepped(0.0);
  const auto accel = [&](std::size_t from, std::size_t to, double size) {
    for (std::size_t k = from; k < to; ++k) run.rows[k].bias_accel = Eigen::Vector3d(0.0, 0.0, -size);
    return run.impossible();
  };
  EXPECT_FALSE(accel(100, 600, 1.9));
  EXPECT_EQ(accel(200, 600, 2.2), run.rows[200].t_ns);
  EXPECT_FALSE(accel(215, 600, 0.0)) << "that was less than a second";
  run.rows[300].sigma_bias_accel = Eigen::Vector3d::Constant(1.0);
  EXPECT_EQ(accel(290, 400, 4.9), run.rows[301].t_ns) << "nobody claims to know it in row 300";
  EXPECT_TRUE(BiasRun([](double) { return 0.25 / kSigma; }).impossible()) << "of the gyroscope";
}

}  // namespace
}  // namespace limber
