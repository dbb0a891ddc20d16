// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <utility>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/simulator.hpp"
#include "run_and_summarize.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

/// A run over a drone's recording that does not state the noise of its pixels.
RunRecord unstated_run(Method method, double white_px, const PixelScenario& pixels = {},
                       double duration = 10.0) {
  Scenario scenario = testing::shipped("drone_none", duration);
  scenario.noise.pixel = white_px;
  scenario.noise.stated = false;
  scenario.pixels = pixels;
  const Recording recording = simulate(scenario, 3);
  RunOptions options;
  options.method = method;
  return run_recording(recording, options, matched_frames(recording));
}

/// What it has learned by its end.
PixelNoiseReport learned(Method method, double white_px, const PixelScenario& pixels = {}) {
  const RunRecord record = unstated_run(method, white_px, pixels);
  EXPECT_TRUE(record.pixel_noise);
  return record.pixel_noise.value_or(PixelNoiseReport{});
}

class UnstatedPixelNoise : public ::testing::TestWithParam<Method> {};

using FullUnstatedPixelNoise = UnstatedPixelNoise;

void expect_found_within_a_fifth(Method method, double true_px) {
  EXPECT_NEAR(learned(method, true_px).sigma_px / true_px, 1.0, 0.2) << true_px;
}

TEST_P(UnstatedPixelNoise, IsFoundWithinAFifthWhereItIsWhite) {
  expect_found_within_a_fifth(GetParam(), 0.25);
}

TEST_P(FullUnstatedPixelNoise, IsFoundWithinAFifthWhereItIsWhite) {
  expect_found_within_a_fifth(GetParam(), 1.5);
}

/// 0.36 px rms in all, of which 0.35 px last: docs/evidence/realistic-pixels.md has 2.5 times the rms right.
TEST_P(UnstatedPixelNoise, IsSeveralTimesTheErrorsWhereTheyLast) {
  PixelScenario pixels;
  pixels.per_track = 0.3;
  pixels.correlated = 0.15;
  const PixelNoiseReport found = learned(GetParam(), 0.1, pixels);
  EXPECT_GT(found.correlation, 0.75);
  EXPECT_GT(found.sigma_px, 0.6);
  EXPECT_LT(found.sigma_px, 1.5);
}

/// Such noise hides whatever makes it necessary.
void expect_remark(Method method) {
  const auto remark = ::testing::Contains(::testing::HasSubstr("px of pixel noise were needed from"));
  const RunRecord usual = unstated_run(method, 1.0, {}, 7.0), large = unstated_run(method, 6.0, {}, 7.0);
  EXPECT_THAT(usual.notes, ::testing::Not(remark));
  EXPECT_THAT(large.notes, remark);
  EXPECT_NEAR(usual.frames.back().sigma_px, usual.pixel_noise->sigma_px, 0.1);
  EXPECT_GT(large.frames.back().sigma_px, 4.0);
}

TEST(UnstatedPixelNoise, IsRemarkedOnWhereItIsMoreThanTracksHave) { expect_remark(Method::kEkf); }

TEST(FullUnstatedPixelNoise, IsRemarkedOnWhereItIsMoreThanTracksHave) { expect_remark(Method::kLcekf); }

/// What a wrong rig leaves in the innovations of a filter that trusts it is no noise, until that is lost
/// altogether.
TEST(UnstatedPixelNoise, IsNotWhatATrustedRigIsOffBy) {
  Scenario scenario = testing::shipped("drone_none", 6.0);
  scenario.noise.pixel = 0.25;
  scenario.noise.stated = false;
  RunOptions options;
  options.method = Method::kEkf;
  options.start = StartMode::kGroundTruth;
  options.assume_error(1) = 0.035;  // two degrees of vergence
  for (const std::uint64_t seed : {3, 5}) {
    const Recording recording = simulate(scenario, seed);
    EXPECT_LE(run_recording(recording, options, matched_frames(recording)).pixel_noise.value().sigma_px, 1.5);
  }
}

const auto name_of = [](const auto& info) { return info.param == Method::kEkf ? "ekf" : "lcekf"; };
const auto kTrustingOrNot = ::testing::Values(Method::kEkf, Method::kLcekf);
INSTANTIATE_TEST_SUITE_P(Methods, UnstatedPixelNoise, kTrustingOrNot, name_of);
INSTANTIATE_TEST_SUITE_P(Methods, FullUnstatedPixelNoise, kTrustingOrNot, name_of);

/// A drone with odometry in the place of an IMU.
Scenario with_odometry(double duration, double velocity, double angular_rate, bool stated = false) {
  Scenario scenario = testing::shipped("drone_none", duration);
  scenario.use_imu = false;
  scenario.odometry = OdometryScenario{20.0, velocity, angular_rate};
  scenario.noise.stated = stated;
  return scenario;
}

/// What a run has learned of odometry that is not alike in all directions.
OdometryNoise learned_odometry(double velocity, double angular_rate, bool stated = false) {
  const Recording recording = simulate(with_odometry(10.0, velocity, angular_rate, stated), 3);
  const RunRecord record = run_recording(recording, {}, matched_frames(recording));
  EXPECT_NE(record.odometry_noise.has_value(), stated);
  return record.odometry_noise.value_or(OdometryNoise{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
}

TEST(UnstatedOdometryNoise, IsFoundWithinAFifth) {
  for (const auto& [velocity, rate] : {std::pair(0.03, 0.01), std::pair(0.2, 0.05)}) {
    const OdometryNoise found = learned_odometry(velocity, rate);
    EXPECT_LT((found.sigma_v.array() / velocity - 1.0).abs().maxCoeff(), 0.2) << found.sigma_v.transpose();
    EXPECT_LT((found.sigma_omega.array() / rate - 1.0).abs().maxCoeff(), 0.2)
        << found.sigma_omega.transpose();
  }
}

/// ANEES where nobody stated how good the odometer is.
double anees(bool doubt_mount, double degrees_off, const RigParameters& rig_off) {
  RunOptions options;
  options.doubt_odometry_mount = doubt_mount;
  options.assume_error.head<6>() = rig_off;
  options.assume_error[first_of(ParameterBlock::kMount) + 2] = degrees_off * std::numbers::pi / 180.0;
  const Recording recording = simulate(with_odometry(15.0, 0.05, 0.01), 5);
  return testing::run_and_summarize(recording, options).anees.value();
}

TEST(UnstatedOdometryMount, MayBeOffByAFewTenthsOfADegree) {
  const double believed = anees(false, 0.5, RigParameters::Zero());
  EXPECT_LT(anees(true, 0.5, RigParameters::Zero()), 1.5);
  EXPECT_GT(believed, 4.0);
}

/// Softened in the place of it, so that no clean bearing of the body is left, landmarks went with every
/// frame.
TEST(UnstatedOdometryMount, LeavesALcekfFreeOfARigThatIsBent) {
  RigParameters bent;
  bent << 0.0, 0.0175, 0.0, 0.012, 0.0, 0.0;  // a degree of vergence, a tenth of the baseline
  EXPECT_LT(anees(true, 0.0, bent), 1.5);
}

TEST(StatedOdometryNoise, IsTakenForWhatItIs) { (void)learned_odometry(0.03, 0.01, true); }

TEST(StatedPixelNoise, IsTakenForWhatItIs) {
  Scenario scenario = testing::shipped("drone_none", 3.0);
  const Recording recording = simulate(scenario, 3);
  EXPECT_FALSE(run_recording(recording, {}, matched_frames(recording)).pixel_noise);
}

}  // namespace
}  // namespace limber
