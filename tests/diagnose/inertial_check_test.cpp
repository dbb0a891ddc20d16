// SPDX-License-Identifier: MIT
// Images and IMU that contradict each other: named with what explains it, and none of sound recordings.
#include "limber/diagnose/inertial_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "limber/core/so3.hpp"
#include "limber/diagnose/judge_run.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Checked {
  RunRecord record;
  SensorOffsets offsets;
  std::optional<OffsetMistake> mistake;
};

Checked checked(const Recording& recording, RunOptions options = {}) {
  Checked out;
  out.record = run_recording(recording, options, matched_frames(recording));
  out.offsets.inertial = check_inertial(recording, options, out.record);
  out.mistake = inertial_mistake(out.offsets);
  return out;
}

Recording with_lever_arm(Recording recording, const Eigen::Vector3d& off) {
  recording.calibration.T_body_cam0.p += off;
  return recording;
}

Recording with_accelerometer(Recording recording, const Eigen::Matrix3d& M) {
  for (ImuSample& sample : recording.imu) {
    sample.accel_imu = M * sample.accel_imu;
  }
  return recording;
}

/// It was named by nothing, with a verdict `ok` and sigmas that were 10 to 30 times too small.
TEST(InertialMistake, NamesALeverArm) {
  for (const std::uint64_t seed : {71u, 72u}) {
    const Recording recording = testing::realistic("drone_none", 12.0, seed);
    const Checked off = checked(with_lever_arm(recording, {0.15, 0.0, 0.0}));
    ASSERT_TRUE(off.mistake) << seed;
    EXPECT_THAT(off.mistake->words, HasSubstr("from where T_BS puts it")) << seed;
    EXPECT_FALSE(off.mistake->sigmas_hold);
    const InertialOffset& lever = off.offsets.inertial->offsets[1];
    ASSERT_EQ(lever.of, InertialFactor::kLeverArm);
    EXPECT_NEAR(lever.value.x(), -0.15, 0.05) << seed;
  }
}

TEST(InertialMistake, IsGoneOnceItIsEstimated) {
  RunOptions options;
  const Recording recording =
      with_lever_arm(testing::realistic("drone_none", 20.0, 71), Eigen::Vector3d(0.15, 0.0, 0.0));
  options.estimated.tail<3>().setConstant(0.3);
  EXPECT_FALSE(checked(recording, options).mistake);
}

/// Both of them: the rig stays what it is, and was `ok`.
TEST(InertialMistake, NamesAPrincipalPoint) {
  Recording recording = testing::realistic("drone_none", 20.0, 73);
  recording.calibration.cam0.cu += 5.0;
  recording.calibration.cam1.cu += 5.0;
  const Checked off = checked(recording);
  ASSERT_TRUE(off.mistake);
  EXPECT_THAT(off.mistake->words, HasSubstr("principal point that is off"));
}

TEST(InertialMistake, NamesAnAccelerometer) {
  const Recording recording = testing::realistic("drone_none", 30.0, 74);
  const Checked scaled = checked(with_accelerometer(recording, 1.03 * Eigen::Matrix3d::Identity()));
  ASSERT_TRUE(scaled.mistake);
  EXPECT_THAT(scaled.mistake->words, HasSubstr("too much"));
  EXPECT_FALSE(scaled.mistake->sigmas_hold);
  const Checked turned = checked(with_accelerometer(recording, so3_exp(Eigen::Vector3d(0.0, 0.04, 0.0))));
  ASSERT_TRUE(turned.mistake);
  EXPECT_THAT(turned.mistake->words, HasSubstr("the accelerometer were turned by"));
  EXPECT_TRUE(turned.mistake->sigmas_hold);  // as noise that is learned
  EXPECT_THAT(turned.mistake->words, Not(HasSubstr("sigmas")));
}

/// Some per cent of each axis, in both directions: all lengths were 1 to 4 % off, and nothing was said, or a
/// lever arm was.
TEST(InertialMistake, NamesTheAxesOfAnAccelerometerThatShowTooMuchOrTooLittle) {
  const Recording recording = testing::realistic("drone_none", 30.0, 75);
  const Checked off =
      checked(with_accelerometer(recording, Eigen::Matrix3d(Eigen::Vector3d(1.03, 0.97, 0.97).asDiagonal())));
  ASSERT_TRUE(off.mistake);
  EXPECT_THAT(off.mistake->words, HasSubstr("the accelerometer's axes showed +"));
  EXPECT_FALSE(off.mistake->sigmas_hold);
  const InertialOffset& axes = off.offsets.inertial->offsets.back();
  ASSERT_EQ(axes.of, InertialFactor::kAccelScales);
  EXPECT_NEAR(axes.value.x(), -0.03, 0.015);
  EXPECT_NEAR(axes.value.y(), 0.03, 0.015);
}

void expect_none(const Recording& recording, const std::string& what) {
  const Checked sound = checked(recording);
  EXPECT_FALSE(sound.mistake) << what << ": " << sound.mistake->words;
}

TEST(InertialMistake, IsNoneOfSoundRecordings) {
  for (const char* const name : {"drone_none", "walk"}) {
    expect_none(testing::realistic(name, 12.0, 81), name);
  }
}

/// A bias as cheap sensors have it, five times what a start expects, was taken for a scale of 4.5 % (seed 92)
/// and for axes that are turned: exit code 1.
TEST(InertialMistake, IsNoneOfALargeBias) {
  Scenario scenario = testing::shipped("drone_none", 20.0, PixelPreset::kRealistic);
  scenario.initial.bias_accel = 0.5;
  for (const std::uint64_t seed : {92u, 95u}) {
    expect_none(simulate(scenario, seed), "drone_none");
  }
}

/// Nor of rigs that are bent, or bend while they move: the rig is free in every frame.
TEST(InertialMistake, IsNoneOfARigThatBends) {
  expect_none(testing::realistic("drone_vibration", 12.0, 83), "drone_vibration");
}

TEST(FullInertialMistake, IsNoneOfSoundAndOfBentRecordings) {
  for (const char* const name : {"drone_none", "drone_moving", "paper_i", "walk", "creeping", "drone_strong",
                                 "drone_vibration", "drone_baseline"}) {
    for (const std::uint64_t seed : {82u, 84u}) {
      expect_none(testing::realistic(name, 20.0, seed), name + std::string(" ") + std::to_string(seed));
    }
  }
}

InertialCheck check_of(InertialFactor factor, double size, double sureness, double gyro_sureness = 0.0) {
  InertialCheck out;
  out.stretches = 2;
  out.offsets.push_back({factor, Eigen::Vector3d(size, 0, 0), 0.1 * size, sureness});
  out.offsets.push_back({InertialFactor::kGyroScale, Eigen::Vector3d(0.01, 0, 0), 1e-3, gyro_sureness});
  return out;
}

TEST(InertialMistake, NeedsSizeAndSurenessAndNoBetterExplanation) {
  const auto named = [](const InertialCheck& check) {
    SensorOffsets offsets;
    offsets.inertial = check;
    return inertial_mistake(offsets).has_value();
  };
  EXPECT_TRUE(named(check_of(InertialFactor::kLeverArm, 0.05, 13.0)));
  EXPECT_FALSE(named(check_of(InertialFactor::kLeverArm, 0.05, 11.0)));
  EXPECT_FALSE(named(check_of(InertialFactor::kLeverArm, 0.02, 100.0)));
  InertialCheck late = check_of(InertialFactor::kLeverArm, 0.05, 13.0);
  late.offsets.push_back({InertialFactor::kClock, Eigen::Vector3d(0.01, 0, 0), 1e-4, 14.0});
  EXPECT_FALSE(named(late));
  EXPECT_FALSE(named(check_of(InertialFactor::kGyroScale, -0.98, 100.0)));  // a rig that stands still
  EXPECT_TRUE(named(check_of(InertialFactor::kAccelScale, 0.02, 13.0)));
  EXPECT_FALSE(named(check_of(InertialFactor::kAccelScale, 0.02, 11.0)));
  EXPECT_TRUE(named(check_of(InertialFactor::kGyroScale, 0.02, 21.0)));
  EXPECT_FALSE(named(check_of(InertialFactor::kGyroScale, 0.02, 19.0)));
}

/// Two axes of the IMU swapped, in seven seconds of few frames: it was lost by metres, and ended as if all
/// were well.
TEST(InertialMistake, IsThatNoMotionExplainsBoth) {
  InertialCheck check;
  check.unexplained = 1;
  SensorOffsets offsets;
  offsets.inertial = check;
  EXPECT_FALSE(inertial_mistake(offsets));  // the run saw no contradiction: the stretch was too hard
  offsets.inertial->contradicted = true;
  ASSERT_TRUE(inertial_mistake(offsets));
  EXPECT_THAT(inertial_mistake(offsets)->words, HasSubstr("no motion explains both"));
  EXPECT_FALSE(inertial_mistake(offsets)->sigmas_hold);
}

TEST(InertialMistake, IsInTheSigmasWhereNoiseIsLearned) {
  SensorOffsets offsets;
  offsets.inertial = check_of(InertialFactor::kLeverArm, 0.001, 1.0, 100.0);
  const auto holds = [&](double gyro, double accel) {
    offsets.inertial->learned = {gyro, accel};
    return inertial_mistake(offsets).value().sigmas_hold;
  };
  EXPECT_THAT(inertial_mistake(offsets)->words, HasSubstr("the gyro showed 1.00"));
  EXPECT_FALSE(holds(1.0, 1.0));
  EXPECT_TRUE(holds(50.0, 1.0));
  EXPECT_FALSE(holds(50.0, 6.0)) << "as of a focal length: the accelerometer is contradicted, too";
}

TEST(InertialMistake, IsNotSaidTwiceNorBesideAClock) {
  SensorOffsets offsets;
  offsets.inertial = check_of(InertialFactor::kMountTurn, 0.01, 100.0);
  EXPECT_TRUE(inertial_mistake(offsets));
  offsets.cameras = TimeOffset{.seconds = 0.02, .sigma = 0.001};
  EXPECT_FALSE(inertial_mistake(offsets));
  offsets.cameras.reset();
  offsets.mount = MountTurn{Eigen::Vector3d(0.01, 0, 0), 1e-4, 50.0};
  EXPECT_FALSE(inertial_mistake(offsets));
  EXPECT_EQ(camera_imu_mistakes(offsets).size(), 1u);  // the mount
}

/// One stretch of 36 frames: every other one of them had been too few, and counted as one that no motion
/// explains.
TEST(InertialCheck, KeepsAsManyFramesOfAStretchAsItNeeds) {
  Recording recording = testing::realistic("drone_none", 7.0, 85);
  std::vector<StereoFrame> some;
  for (std::size_t k = 0; k < recording.frames.size(); k += 4) {
    some.push_back(recording.frames[k]);
  }
  ASSERT_EQ(some.size(), 36u);
  recording.frames = some;
  const Checked sparse = checked(recording);
  ASSERT_TRUE(sparse.offsets.inertial);
  EXPECT_EQ(sparse.offsets.inertial->stretches, 1u);
  EXPECT_EQ(sparse.offsets.inertial->unexplained, 0u);
}

/// A start from the truth is watched, too; without an IMU there is nothing to ask.
TEST(InertialCheck, IsOfRunsWithAnImu) {
  Recording recording = testing::realistic("drone_none", 8.0, 84);
  EXPECT_TRUE(checked(recording).offsets.inertial);
  recording.imu.clear();
  EXPECT_FALSE(checked(recording).offsets.inertial);
}

}  // namespace
}  // namespace limber
