// SPDX-License-Identifier: MIT
#include "limber/run/run_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "message_of.hpp"
#include "run/short_recording.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using testing::message_of;
using testing::short_recording;
using testing::vision_only;
using testing::without_imu;

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(SetUpRun, ConstrainsAllSixWhereTheImuFixesTheScale) {
  const RunSetup setup = set_up_run(short_recording(), {});
  EXPECT_EQ(setup.navigator.motion, MotionModel::kImu);
  EXPECT_EQ(setup.navigator.constraints.kind, ConstraintSet::Kind::kFull);
  EXPECT_THAT(setup.notes, Contains(HasSubstr("constraints full: the scale comes from the IMU")));
  EXPECT_THAT(setup.notes, Contains(HasSubstr("odometry beside it is not used")));
}

TEST(SetUpRun, ConstrainsAllSixWhereTheOdometryFixesTheScale) {
  const RunSetup setup = set_up_run(without_imu(short_recording()), {});
  EXPECT_EQ(setup.navigator.motion, MotionModel::kOdometry);
  EXPECT_EQ(setup.navigator.constraints.kind, ConstraintSet::Kind::kFull);
  EXPECT_THAT(setup.notes, Contains(HasSubstr("constraints full: the scale comes from the odometry")));
}

TEST(SetUpRun, KeepsTheLengthOfTheBaselineWhereNothingElseFixesTheScale) {
  const RunSetup setup = set_up_run(vision_only(short_recording()), {});
  EXPECT_EQ(setup.navigator.motion, MotionModel::kConstantVelocity);
  EXPECT_EQ(setup.navigator.constraints.kind, ConstraintSet::Kind::kRotationDirection);
  EXPECT_THAT(setup.notes, Contains(HasSubstr("constant-velocity model")));
  EXPECT_THAT(setup.notes, Contains(HasSubstr("constraints rotation+direction")));
}

TEST(SetUpRun, BoundsThePointsOfAnUpdateUnlessToldHowMany) {
  Recording recording = short_recording();
  EXPECT_EQ(set_up_run(recording, {}).navigator.map.points_per_update, 150U);
  recording.images.emplace_back();
  EXPECT_EQ(set_up_run(recording, {}).navigator.map.points_per_update, 80U);
  RunOptions options;
  options.points_per_update = 1000;
  EXPECT_EQ(set_up_run(recording, options).navigator.map.points_per_update, 1000U);
}

TEST(SetUpRun, FollowsAChosenConstraintSetWithoutANote) {
  RunOptions options;
  options.constraints = constraint_set_from_string("ax,tx");
  const RunSetup setup = set_up_run(short_recording(), options);
  EXPECT_EQ(to_string(setup.navigator.constraints), "ax,tx");
  EXPECT_THAT(setup.notes, Not(Contains(HasSubstr("constraints"))));
}

TEST(SetUpRun, TakesTheNoiseOfTheRecordingAndSaysWhereItGuesses) {
  Recording recording = short_recording();
  recording.pixel_noise = PixelNoise(0.1, 0.2, 0.3, 0.4);
  EXPECT_EQ(set_up_run(recording, {}).navigator.sigma_px, PixelNoise(0.1, 0.2, 0.3, 0.4));
  EXPECT_EQ(set_up_run(recording, {}).navigator.imu_noise.accel_density, recording.imu_noise->accel_density);
  EXPECT_THAT(set_up_run(recording, {}).notes, Not(Contains(HasSubstr("not given"))));

  RunOptions options;
  options.sigma_px = 0.7;
  EXPECT_EQ(set_up_run(recording, options).navigator.sigma_px, PixelNoise::Constant(0.7));

  recording.pixel_noise.reset();
  recording.imu_noise.reset();
  EXPECT_EQ(set_up_run(recording, {}).navigator.sigma_px, PixelNoise::Constant(1.0));
  EXPECT_THAT(set_up_run(recording, {}).notes,
              Contains(HasSubstr("pixel noise not given: learned, from 1 px on")));
  EXPECT_THAT(set_up_run(recording, {}).notes, Contains(HasSubstr("IMU noise not given")));

  recording = without_imu(recording);
  recording.odometry_noise.reset();
  EXPECT_THAT(set_up_run(recording, {}).notes, Contains(HasSubstr("odometry noise not given")));
}

TEST(SetUpRun, DoubtsTheMountOfOdometryOfWhichNobodyStatesHowGoodItIs) {
  Recording recording = without_imu(short_recording());
  EXPECT_FALSE(set_up_run(recording, {}).navigator.doubt_odometry_mount);
  recording.odometry_noise.reset();
  EXPECT_TRUE(set_up_run(recording, {}).navigator.doubt_odometry_mount);
  RunOptions options;
  options.doubt_odometry_mount = false;
  EXPECT_FALSE(set_up_run(recording, options).navigator.doubt_odometry_mount);
}

TEST(SetUpRun, DoubtsTheScaleOfOdometryOfWhichNobodyStatesHowGoodItIs) {
  Recording recording = without_imu(short_recording());
  EXPECT_EQ(set_up_run(recording, {}).navigator.odometry_scale, 0.0);
  RunOptions options;
  options.odometry_scale = 0.02;
  EXPECT_EQ(set_up_run(recording, options).navigator.odometry_scale, 0.02);
  recording.odometry_noise.reset();
  EXPECT_EQ(set_up_run(recording, {}).navigator.odometry_scale, 0.01);
}

TEST(SetUpRun, AddsTheErrorToTheAssumedRigAndLeavesTheMountingAlone) {
  const Recording recording = short_recording();
  RunOptions options;
  options.assume_error.head<6>() << 0.01, 0.02, 0.03, 0.1, 0.2, 0.3;
  const RunSetup setup = set_up_run(recording, options);
  EXPECT_TRUE(
      setup.calibration.theta.isApprox(recording.calibration.theta + options.assume_error.head<6>(), 1e-15));
  EXPECT_EQ(setup.calibration.T_body_cam0.R, recording.calibration.T_body_cam0.R);
  EXPECT_EQ(setup.calibration.T_body_cam0.p, recording.calibration.T_body_cam0.p);
}

TEST(SetUpRun, RefusesAnErrorThatMakesTheBaselineVanish) {
  const Recording recording = short_recording();
  RunOptions options;
  options.assume_error.head<6>() = -recording.calibration.theta;
  EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }), HasSubstr("baseline"));
}

TEST(SetUpRun, RefusesAnErrorThatLeavesNoSuchRig) {
  const Recording recording = short_recording();
  RunOptions options;
  options.assume_error[3] = 3.0;  // the baseline is 2 m
  EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }),
              HasSubstr("turns the baseline [-2, 0, 0] m into [1, 0, 0] m"));
  options.assume_error[3] = -21.0;
  EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }),
              HasSubstr("at most 10 baselines of 2 m, found 21 m"));
  options.assume_error[3] = -19.0;
  EXPECT_NO_THROW((void)set_up_run(recording, options));
}

TEST(SetUpRun, RefusesErrorsThatLeaveNoSuchCamera) {
  const Recording recording = short_recording();
  RunOptions options;
  options.assume_error[6] = -recording.calibration.cam0.fu;
  EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }), HasSubstr("focal lengths positive"));
  options.assume_error[6] = 0.0;
  options.assume_error[17] = 0.2;
  EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }),
              HasSubstr("time offsets within ±0.1 s, found 0.2 s"));
}

TEST(SetUpRun, RefusesPixelNoiseThatNoPixelHas) {
  const Recording recording = short_recording();
  for (const double sigma : {1e-7, 1001.0}) {
    RunOptions options;
    options.sigma_px = sigma;
    EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }), HasSubstr("pixel noise"));
  }
}

TEST(SetUpRun, LetsTheRigWalkInProportionToItsBaseline) {
  Recording recording = short_recording();
  // Table 1 of the paper: 1e-6 rad^2 and 1 mm^2 in every 10 ms, for a baseline of 2 m.
  const RigParameters paper = *set_up_run(recording, {}).navigator.theta_walk;
  EXPECT_NEAR(paper[0], 1e-4, 1e-18);
  EXPECT_NEAR(paper[3], 1e-4, 1e-18);
  recording.calibration.theta[3] = -0.2;
  const NavigatorOptions small = set_up_run(recording, {}).navigator;
  EXPECT_NEAR((*small.theta_walk)[0], 1e-4, 1e-18);
  EXPECT_NEAR((*small.theta_walk)[3], 1e-6, 1e-18);
  EXPECT_NEAR(small.theta_sigma[0], 0.1 * kDegree, 1e-15);
  EXPECT_NEAR(small.theta_sigma[3], 0.01, 1e-15);
}

TEST(SetUpRun, TakesGravityAndTheNoiseOfTheMotionModelAsTold) {
  const Recording recording = vision_only(short_recording());
  const NavigatorOptions defaults = set_up_run(recording, {}).navigator;
  EXPECT_EQ(defaults.gravity, 9.81);
  EXPECT_EQ(defaults.constant_velocity_noise.acceleration_density, 0.5);
  RunOptions options;
  options.gravity = 1.62;
  options.constant_velocity_noise = ConstantVelocityNoise{0.25, 0.125};
  const NavigatorOptions told = set_up_run(recording, options).navigator;
  EXPECT_EQ(told.gravity, 1.62);
  EXPECT_EQ(told.constant_velocity_noise.acceleration_density, 0.25);
  EXPECT_EQ(told.constant_velocity_noise.angular_acceleration_density, 0.125);
}

TEST(SetUpRun, RefusesAGroundTruthStartWithoutGroundTruth) {
  Recording recording = short_recording();
  recording.truth.motion.states.clear();
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }), HasSubstr("use --init auto"));
}

TEST(SetUpRun, RefusesAnOracleWithNobodyToTellIt) {
  Recording recording = short_recording();
  recording.truth.rig.clear();
  RunOptions options;
  options.method = Method::kOracle;
  EXPECT_THAT(message_of([&] { (void)set_up_run(recording, options); }), HasSubstr("calibration_truth0"));
}

}  // namespace
}  // namespace limber
