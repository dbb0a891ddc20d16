// SPDX-License-Identifier: MIT
#include "limber/run/rig_parts.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "message_of.hpp"

namespace limber {
namespace {

const RigParameters kGiven = (RigParameters() << 0.01, -0.02, 0.005, -0.11, 0.001, -0.002).finished();
const RigParameters kBounds = RigParameters::Constant(0.02);

RigParameters normal(std::mt19937& random) {
  std::normal_distribution<double> draw;
  RigParameters out;
  for (Eigen::Index k = 0; k < 6; ++k) {
    out(k) = draw(random);
  }
  return out;
}

/// Windows of a true rig: information of different sizes and directions, errors as it says times `worse`.
std::vector<RigPart> windows_of(const RigParameters& truth, std::size_t count, double worse,
                                std::mt19937& random) {
  std::vector<RigPart> out(count);
  for (RigPart& window : out) {
    RigMatrix root = RigMatrix::Identity() * 1000.0;
    for (Eigen::Index k = 0; k < 6; ++k) {
      root.col(k) += 300.0 * normal(random);
    }
    window.information = root * root.transpose();
    window.theta = truth + worse * root.transpose().inverse() * normal(random);
  }
  return out;
}

TEST(FitRig, ItsCovarianceIsThatOfItsErrors) {
  std::mt19937 random(7);
  constexpr int kRuns = 400;
  for (const double worse : {1.0, 4.0}) {
    double nees = 0.0;
    for (int run = 0; run < kRuns; ++run) {
      const RigFit fit = fit_rig(windows_of(kGiven, 8, worse, random), kGiven, kBounds);
      ASSERT_TRUE(fit.seen.all());
      const RigParameters error = fit.theta - kGiven;
      nees += error.dot(fit.covariance.ldlt().solve(error)) / (6.0 * kRuns);
    }
    EXPECT_GT(nees, 0.8) << worse;
    EXPECT_LT(nees, 1.2) << worse;
  }
}

/// Windows that see the same cells: noise of unit size in each row, and an error of twice that which all rows
/// of a cell have in all windows. The length tx may be known beside them.
std::vector<RigPart> windows_of_cells(const RigParameters& truth, std::size_t count, std::mt19937& random,
                                      double sigma_of_length = 1.0, std::size_t cells = 25) {
  using Rows = Eigen::Matrix<double, 10, 6>;
  std::normal_distribution<double> draw;
  std::vector<Rows> slopes(cells);
  std::vector<double> kept(cells);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    for (double& number : slopes[cell].reshaped()) number = 300.0 * draw(random);
    kept[cell] = 2.0 * draw(random);
  }
  std::vector<RigPart> out(count);
  for (RigPart& window : out) {
    std::vector<Eigen::Matrix<double, 10, 1>> errors(cells);
    RigParameters pull = RigParameters::Zero();
    window.information(3, 3) = 1.0 / (sigma_of_length * sigma_of_length);
    for (std::size_t cell = 0; cell < cells; ++cell) {
      for (double& error : errors[cell]) error = draw(random) + kept[cell];
      window.information += slopes[cell].transpose() * slopes[cell];
      pull += slopes[cell].transpose() * errors[cell];
    }
    const RigParameters step = window.information.ldlt().solve(pull);
    window.theta = truth + step;
    for (std::size_t cell = 0; cell < cells; ++cell) {
      window.scores[static_cast<int>(cell)] = {
          slopes[cell].transpose() * (errors[cell] - slopes[cell] * step),
          slopes[cell].transpose() * slopes[cell]};
    }
  }
  return out;
}

TEST(FitRig, WhatACellDoesInAllWindowsIsInItsCovariance) {
  std::mt19937 random(9);
  constexpr int kRuns = 300;
  double with = 0.0, without = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<RigPart> windows = windows_of_cells(kGiven, 6, random);
    const auto nees = [&] {
      const RigFit fit = fit_rig(windows, kGiven, kBounds);
      const RigParameters error = fit.theta - kGiven;
      return error.dot(fit.covariance.ldlt().solve(error)) / (6.0 * kRuns);
    };
    with += nees();
    for (RigPart& window : windows) window.scores.clear();
    without += nees();
  }
  EXPECT_GT(without, 10.0);
  EXPECT_GT(with, 0.6);
  EXPECT_LT(with, 1.4);
}

/// Six directions out of a dozen cells: as they come, the small ones are far too small (a NEES of 1.6).
TEST(FitRig, FewCellsDoNotMakeADirectionTooSure) {
  std::mt19937 random(11);
  constexpr int kRuns = 300;
  double nees = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const RigFit fit = fit_rig(windows_of_cells(kGiven, 6, random, 1.0, 12), kGiven, kBounds);
    const RigParameters error = fit.theta - kGiven;
    nees += error.dot(fit.covariance.ldlt().solve(error)) / (6.0 * kRuns);
  }
  EXPECT_GT(nees, 0.6);
  EXPECT_LT(nees, 1.2);
}

TEST(FitRig, ALengthThatIsTrustedStaysSo) {
  std::mt19937 random(10);
  constexpr double kTrusted = 1e-6;  // [m]; the points alone: 1e-4
  const std::vector<RigPart> windows = windows_of_cells(kGiven, 4, random, kTrusted);
  EXPECT_LT(std::sqrt(fit_rig(windows, kGiven, kBounds).covariance(3, 3)), 2.0 * kTrusted);
}

TEST(FitRig, WhatNoWindowSeesIsLeftAlone) {
  std::mt19937 random(8);
  RigParameters truth = kGiven;
  truth(1) += 0.05;
  std::vector<RigPart> windows = windows_of(truth, 6, 1.0, random);
  RigMatrix blind = RigMatrix::Identity();
  blind(3, 3) = 0.0;
  for (RigPart& window : windows) {
    window.information = blind * window.information * blind;
    window.theta(3) += 7.0;  // means nothing
  }
  const RigFit fit = fit_rig(windows, kGiven, kBounds);
  EXPECT_FALSE(fit.seen[3]);
  EXPECT_EQ(fit.seen.count(), 5u);
  EXPECT_EQ(fit.theta(3), kGiven(3));
  EXPECT_DOUBLE_EQ(fit.covariance(3, 3), kBounds(3) * kBounds(3));
  EXPECT_NEAR(fit.theta(1), truth(1), 5e-3);
}

/// Windows that know tx in relation to ty, and either alone by `sigma` together.
std::vector<RigPart> windows_of_a_pair(const RigParameters& truth, std::size_t count, double sigma,
                                       std::mt19937& random) {
  RigParameters together = RigParameters::Zero();
  together(3) = together(4) = std::sqrt(0.5);
  const double known = 1.0 / (1e-3 * 1e-3 * static_cast<double>(count));  // 1 mm, of all windows
  const double unknown = 1.0 / (2.0 * sigma * sigma * static_cast<double>(count));
  const RigMatrix information =
      known * RigMatrix::Identity() + (unknown - known) * together * together.transpose();
  const RigMatrix root = information.llt().matrixL();
  std::vector<RigPart> out(count);
  for (RigPart& window : out) {
    window.information = information;
    window.theta = truth + root.transpose().inverse() * normal(random);
  }
  return out;
}

TEST(FitRig, WhatIsLeftAloneIsInTheCovarianceOfTheOthers) {
  std::mt19937 random(12);
  std::normal_distribution<double> draw;
  constexpr int kRuns = 300;
  double nees = 0.0;
  int left_one = 0;
  for (int run = 0; run < kRuns; ++run) {
    RigParameters truth = kGiven;  // right within the bound, as is assumed
    truth(3) += kBounds(3) * draw(random);
    const RigFit fit = fit_rig(windows_of_a_pair(truth, 6, 0.05, random), kGiven, kBounds);
    left_one += (~fit.seen).count() == 1 ? 1 : 0;
    const RigParameters error = fit.theta - truth;
    nees += error.dot(fit.covariance.ldlt().solve(error)) / (6.0 * kRuns);
  }
  EXPECT_GT(left_one, 0.97 * kRuns) << "one of the pair is known by the other, but where both are surely off";
  EXPECT_GT(nees, 0.8);
  EXPECT_LT(nees, 1.2);
}

TEST(FitRig, AnAxisThatIsSurelyOffIsNotLeftAloneThoughItIsKnownBadly) {
  std::mt19937 random(13);
  RigParameters truth = kGiven;
  truth(3) += 0.4;
  truth(4) += 0.4;
  const RigFit fit = fit_rig(windows_of_a_pair(truth, 6, 0.05, random), kGiven, kBounds);
  EXPECT_TRUE(fit.seen.all());
  EXPECT_GT(std::sqrt(fit.covariance(3, 3)), kBounds(3));
  EXPECT_NEAR(fit.theta(3), truth(3), 0.2);
}

TEST(FitRig, WithoutWindowsThereIsNone) {
  EXPECT_EQ(testing::message_of([] { static_cast<void>(fit_rig({}, kGiven, kBounds)); }),
            "fit_rig: no window");
}

TEST(HeldOut, ASoundRigIsNotImprovedAndAWrongOneIs) {
  std::mt19937 random(9);
  constexpr int kRuns = 100;
  int sound_kept = 0, wrong_mended = 0;
  for (int run = 0; run < kRuns; ++run) {
    const HeldOut sound = held_out(windows_of(kGiven, 6, 1.0, random), kGiven, kBounds);
    sound_kept += sound.fitted > sound.given ? 1 : 0;
    const HeldOut wrong =
        held_out(windows_of(kGiven + RigParameters::Constant(0.01), 6, 1.0, random), kGiven, kBounds);
    wrong_mended += wrong.fitted < wrong.given ? 1 : 0;
  }
  EXPECT_GE(sound_kept, 85) << "an overfit half costs the other half twice what it gains";
  EXPECT_EQ(wrong_mended, kRuns);
}

TEST(HeldOut, OneWindowHasNobodyToJudgeIt) {
  std::mt19937 random(10);
  const HeldOut one = held_out(windows_of(kGiven, 1, 1.0, random), kGiven, kBounds);
  EXPECT_EQ(one.given, 0.0);
  EXPECT_EQ(one.fitted, 0.0);
}

}  // namespace
}  // namespace limber
