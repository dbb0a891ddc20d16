// SPDX-License-Identifier: MIT
#include "limber/health/tolerance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "health/stereo_world.hpp"

namespace limber {
namespace {

using enum HealthVerdict;

TEST(Tolerance, JudgesTheIntervalAndNotTheEstimate) {
  const Band band{0.3, 1.0};
  EXPECT_EQ(judge({0.1, 0.0, 0.29}, band), kOk);
  EXPECT_EQ(judge({0.1, 0.0, 0.31}, band), kCannotTell);
  EXPECT_EQ(judge({0.5, 0.31, 0.9}, band), kDegraded);
  EXPECT_EQ(judge({0.9, 0.31, 3.0}, band), kDegraded);
  EXPECT_EQ(judge({2.0, 0.29, 9.0}, band), kCannotTell);
  EXPECT_EQ(judge({2.0, 1.01, 9.0}, band), kDecalibrated);
}

TEST(Tolerance, AnAxisWithinItsSigmaIsNeverWrong) {
  RigEstimate estimate;
  estimate.delta(1) = 0.01;
  estimate.covariance(1, 1) = 0.01 * 0.01;
  EXPECT_EQ(judge(axis_size(estimate, 1), Band{1e-4, 2e-4}), kCannotTell);
}

TEST(Tolerance, VergenceAndBaselineScaleADepthAsGeometryHasIt) {
  RigParameters theta = RigParameters::Zero();
  theta(3) = -0.1;
  const RigParameters slope = depth_slope(theta, 90.0);
  // z = f b / disparity: a disparity that is larger by d(ay) makes it smaller by 90 d(ay) of itself.
  EXPECT_NEAR(std::abs(slope(1)), 90.0, 0.1);
  EXPECT_NEAR(std::abs(slope(3)), 10.0, 0.1);  // per metre: 1 mm of 100 mm is 1 %
  EXPECT_NEAR(slope(0), 0.0, 1e-3);
  EXPECT_NEAR(slope(2), 0.0, 1e-3);
}

TEST(Tolerance, TheEffectIsARootMeanSquareWithoutWhatNoiseAddsToIt) {
  const Eigen::VectorXd x = Eigen::VectorXd::Constant(1, 0.002);
  const Eigen::MatrixXd V = Eigen::MatrixXd::Constant(1, 1, 1e-6);
  const SizeInterval size = root_of_form(x, V, Eigen::MatrixXd::Constant(1, 1, 400.0 * 400.0));
  EXPECT_NEAR(size.size, 400.0 * std::sqrt(4e-6 - 1e-6), 1e-9);
  EXPECT_EQ(size.low, 0.0);
  EXPECT_GT(size.high, 1.2);
}

TEST(Tolerance, AnAxisBandIsWhereItsEffectAloneReachesTheTolerance) {
  RigParameters px = RigParameters::Zero();
  px(0) = 400.0;
  RigParameters slope = RigParameters::Zero();
  slope(1) = 90.0;
  Tolerance tolerance;
  tolerance.axes[2] = Band{0.1, 0.2};
  const auto bands = axis_bands(tolerance, px, slope);
  EXPECT_NEAR(bands[0].ok, 0.3 / 400.0, 1e-12);
  EXPECT_NEAR(bands[1].wrong, 0.1 / 90.0, 1e-12);
  EXPECT_EQ(bands[2].wrong, 0.2);
  EXPECT_TRUE(std::isinf(bands[3].ok) && std::isinf(bands[3].wrong));  // nothing shows it
}

TEST(Tolerance, TheMostLikelyAxisIsTheOneThatExplainsTheOffset) {
  // Nod and down are hardly told apart (correlation 0.99): what lies along their common line is found anyway.
  RigEstimate estimate;
  estimate.covariance.diagonal().setOnes();
  estimate.covariance(0, 4) = estimate.covariance(4, 0) = 0.99;
  estimate.delta(0) = 5.0;
  EXPECT_EQ(most_likely_axis(estimate, {}), 0);
  estimate.delta(4) = 5.0;
  estimate.delta(0) = 0.0;
  EXPECT_EQ(most_likely_axis(estimate, {}), 4);
}

TEST(Tolerance, ASmallErrorThatIsKnownWellDoesNotHideALargeOne) {
  RigEstimate estimate;
  estimate.covariance.diagonal() << 1e-6, 1.0, 1.0, 1.0, 1.0, 1.0;
  estimate.delta << 0.02, 0.0, 0.0, 5.0, 0.0, 0.0;  // 20 sigma, 5 sigma
  std::array<Band, 6> bands;
  bands.fill({0.1, 0.2});
  EXPECT_EQ(most_likely_axis(estimate, bands), 3);
  bands.fill({10.0, 20.0});
  EXPECT_EQ(most_likely_axis(estimate, bands), 0);
}

TEST(Tolerance, RefusesBandsThatAreNone) {
  Tolerance tolerance;
  tolerance.depth = {0.2, 0.1};
  EXPECT_THROW(tolerance.check(), std::invalid_argument);
  tolerance.depth = {0.0, 0.1};
  EXPECT_THROW(tolerance.check(), std::invalid_argument);
}

}  // namespace
}  // namespace limber
