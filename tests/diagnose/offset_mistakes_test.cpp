// SPDX-License-Identifier: MIT
// Clocks and mounts that are off: named from a few seconds that turn, no accusation of the rig, and none of
// sound ones.
#include "limber/diagnose/offset_mistakes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <span>

#include "limber/core/angle.hpp"
#include "limber/core/so3.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using enum HealthVerdict;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Stamps of the IMU are moved by that.
void move_imu(Recording& recording, double seconds) {
  for (ImuSample& sample : recording.imu) {
    sample.t_ns += static_cast<std::int64_t>(1e9 * seconds);
  }
}

std::vector<std::string> mistakes_in(const Recording& recording) {
  return clock_mistakes(sensor_offsets(recording.calibration, recording.frames, recording.imu));
}

TEST(ClockMistakes, AreNamedFromEightSecondsThatTurn) {
  for (const std::uint64_t seed : {51u, 52u, 53u}) {
    for (const double seconds : {0.02, -0.1}) {
      Recording recording = testing::realistic("drone_none", 8.0, seed);
      move_imu(recording, seconds);
      EXPECT_THAT(mistakes_in(recording), ElementsAre(HasSubstr("beside the IMU, the cameras are taken")))
          << seed << ' ' << seconds;
    }
  }
}

/// The sigma of an offset from few seconds is itself a guess, the more where one of them alone turns.
TEST(ClockMistakes, AreNoneOfSoundClocksInPiecesOfFewSeconds) {
  for (const char* const name : {"drone_none", "drone_moving"}) {
    const Recording recording = testing::realistic(name, 30.0, 61);
    for (const double length : {4.0, 6.0}) {
      const auto frames =
          static_cast<std::size_t>(length * static_cast<double>(recording.frames.size()) / 30.0);
      for (std::size_t n = 0; n + frames <= recording.frames.size(); n += frames) {
        const std::span piece = std::span(recording.frames).subspan(n, frames);
        EXPECT_THAT(clock_mistakes(sensor_offsets(recording.calibration, piece, recording.imu)), IsEmpty())
            << name << ' ' << length << " s from frame " << n;
      }
    }
  }
}

/// What the calibration says of the clock is no mistake.
TEST(ClockMistakes, AreNoneWhereTheCalibrationKnowsTheOffset) {
  Recording recording = testing::realistic("drone_none", 8.0, 54);
  move_imu(recording, 0.02);
  recording.calibration.time_offset_s = {0.02, 0.02};
  EXPECT_THAT(mistakes_in(recording), IsEmpty());
  recording.calibration.time_offset_s = {0.04, 0.04};
  EXPECT_THAT(mistakes_in(recording), ElementsAre(HasSubstr("later than stamped, and 40.0 ms are assumed")));
}

TEST(ClockMistakes, NeedMoreSigmasOfFewerSeconds) {
  const auto named = [](double dof) {
    return !clock_mistakes({.cam1 = {}, .cameras = TimeOffset{.seconds = 0.01, .sigma = 0.001, .dof = dof}})
                .empty();
  };
  EXPECT_FALSE(named(3.0));
  EXPECT_TRUE(named(7.0));
  EXPECT_THAT(clock_mistakes({.cam1 = {}, .cameras = TimeOffset{.seconds = 0.0029, .sigma = 1e-5}}),
              IsEmpty());
}

/// Of nod, and of what depths tell of vergence.
HealthSummary wrong_by(HealthVerdict epipolar, HealthVerdict depth) {
  HealthSummary out;
  out.present.axes.fill(kOk);
  out.present.axes[0] = epipolar;
  out.present.axes[1] = depth;
  out.present.by_epipolar = epipolar;
  out.present.by_depth = depth;
  out.present.by_movement = kOk;
  out.verdict = out.present.verdict = worst(epipolar, depth);
  return out;
}

/// A run that has corrected it navigates and judges with the right one.
TEST(ClockMistakes, AreNoneOfAClockThatTheRunHasCorrected) {
  SensorOffsets offsets{.cam1 = {}, .cameras = TimeOffset{.seconds = 0.04, .sigma = 1e-4}};
  const HealthSummary sound = wrong_by(kOk, kOk);
  EXPECT_THAT(imu_clock_mistake(offsets).value(), HasSubstr("40.0 ± 0.1 ms later than stamped"));
  EXPECT_FALSE(corrected_clock_in_words(offsets));
  EXPECT_EQ(verdict_beside(offsets, sound), kCannotTell);
  offsets.corrected_cameras = 0.0385;
  EXPECT_THAT(clock_mistakes(offsets), IsEmpty());
  EXPECT_THAT(corrected_clock_in_words(offsets).value(), HasSubstr("40.0 ± 0.1 ms later than stamped"));
  EXPECT_EQ(verdict_beside(offsets, sound), kOk);
  offsets.corrected_cameras = 0.02;
  EXPECT_THAT(clock_mistakes(offsets), ElementsAre(HasSubstr("and 20.0 ms are assumed")));
  EXPECT_FALSE(corrected_clock_in_words(offsets));
}

TEST(ClockMistakes, AreThoseOfTheRunWhereItsClockJumped) {
  RunRecord record;
  EXPECT_EQ(corrected_clock(record), 0.0);
  record.start.clock_offset_ns = 40'000'000;
  EXPECT_DOUBLE_EQ(corrected_clock(record), 0.04);
  FrameReport frame;
  frame.inputs.contradiction.emplace().clock_offset_ns = 41'000'000;
  record.frames = {FrameReport{}, frame, FrameReport{}};
  EXPECT_DOUBLE_EQ(corrected_clock(record), 0.041);
  frame.inputs.contradiction->clock_offset_ns = 60'000'000;
  record.frames.push_back(frame);
  EXPECT_EQ(corrected_clock(record), 0.0);
}

TEST(VerdictBesideClocks, DoesNotAccuseTheRigOfWhatAClockDoes) {
  const SensorOffsets sound{.cam1 = {}, .cameras = TimeOffset{.seconds = 0.001, .sigma = 0.001}};
  const SensorOffsets imu_off{.cam1 = {}, .cameras = TimeOffset{.seconds = 0.02, .sigma = 0.001}};
  const SensorOffsets cam1_off{.cam1 = TimeOffset{.seconds = 0.02, .sigma = 0.001}, .cameras = {}};
  EXPECT_EQ(verdict_beside(sound, wrong_by(kOk, kDecalibrated)), kDecalibrated);
  EXPECT_EQ(verdict_beside(imu_off, wrong_by(kOk, kDecalibrated)), kCannotTell);
  EXPECT_EQ(verdict_beside(imu_off, wrong_by(kDecalibrated, kDecalibrated)), kDecalibrated);
  EXPECT_EQ(verdict_beside(sound, wrong_by(kOk, kOk)), kOk);
  EXPECT_EQ(verdict_beside(imu_off, wrong_by(kOk, kOk)), kCannotTell);  // exit code 0 is a promise
  EXPECT_EQ(verdict_beside(cam1_off, wrong_by(kDecalibrated, kOk)), kCannotTell);
  // A vergence that is off by degrees moves points off their lines, too: it is nothing that lines have said.
  HealthSummary turned = wrong_by(kOk, kDecalibrated);
  turned.present.by_epipolar = kDecalibrated;
  EXPECT_EQ(verdict_beside(imu_off, turned), kCannotTell);
}

TEST(VerdictByLines, IsThatOfALostRun) {
  EXPECT_EQ(verdict_by_lines(wrong_by(kOk, kDecalibrated)), kCannotTell);
  EXPECT_EQ(verdict_by_lines(wrong_by(kDecalibrated, kDecalibrated)), kDecalibrated);
  EXPECT_EQ(verdict_by_lines(wrong_by(kOk, kOk)), kCannotTell);
}

/// Of a pair one above the other the vergence is ax, which depths tell, and lines tell ay.
TEST(VerdictBesideClocks, KnowsWhatLinesTellOfAPairOneAboveTheOther) {
  const SensorOffsets imu_off{.cam1 = {}, .cameras = TimeOffset{.seconds = 0.02, .sigma = 0.001}};
  HealthSummary summary = wrong_by(kDecalibrated, kOk);
  summary.present.vergence = 0;
  EXPECT_EQ(verdict_beside(imu_off, summary), kCannotTell);
  summary = wrong_by(kOk, kDecalibrated);
  summary.present.vergence = 0;
  EXPECT_EQ(verdict_beside(imu_off, summary), kDecalibrated);
}

/// The calibration's mount is turned against the true one by so many degrees, about body axes.
SensorOffsets beside_turned_mount(Recording recording, const Eigen::Vector3d& degrees) {
  Eigen::Matrix3d& R = recording.calibration.T_body_cam0.R;
  R = so3_exp(Eigen::Vector3d(degrees / kToDegrees)) * R;
  return sensor_offsets(recording.calibration, recording.frames, recording.imu);
}

TEST(MountMistake, IsNamedByItsSize) {
  for (const std::uint64_t seed : {55u, 56u}) {
    const Recording recording = testing::realistic("drone_none", 20.0, seed);
    for (const Eigen::Vector3d& degrees :
         {Eigen::Vector3d(0.6, 0, 0), Eigen::Vector3d(0, -0.6, 0), Eigen::Vector3d(0.4, 0.4, 0.3)}) {
      const SensorOffsets offsets = beside_turned_mount(recording, degrees);
      ASSERT_TRUE(offsets.mount);
      // True minus assumed, in the direction that is told.
      const Eigen::Vector3d turn = kToDegrees * offsets.mount->turn;
      EXPECT_NEAR(turn.norm(), -degrees.dot(turn.normalized()), 0.15) << degrees.transpose();
      EXPECT_THAT(offset_mistakes(offsets), ElementsAre(HasSubstr("cam0 is turned by")))
          << degrees.transpose();
      EXPECT_THAT(clock_mistakes(offsets), IsEmpty());
    }
  }
}

/// Lens errors of 0.2 px rms look like up to 0.3 deg, more where the view is narrow.
TEST(MountMistake, IsNoneOfSoundMounts) {
  for (const char* const name : {"drone_none", "drone_moving", "paper_i", "creeping"}) {
    for (const std::uint64_t seed : {61u, 62u, 63u}) {
      const SensorOffsets offsets =
          beside_turned_mount(testing::realistic(name, 15.0, seed), Eigen::Vector3d::Zero());
      EXPECT_THAT(offset_mistakes(offsets), IsEmpty()) << name << ' ' << seed;
    }
  }
}

/// A bias that is another from that second on.
Recording with_gyro_step(Recording recording, double second, const Eigen::Vector3d& step) {
  const std::int64_t from_ns = recording.imu.front().t_ns + static_cast<std::int64_t>(1e9 * second);
  for (ImuSample& sample : recording.imu) {
    sample.omega_imu += sample.t_ns >= from_ns ? step : Eigen::Vector3d::Zero();
  }
  return recording;
}

/// They were: a mount that is turned by 1 deg, and a gyro's axis whose scale is off by 19 to 28 %.
TEST(MountMistake, IsNoneOfAGyroWhoseBiasSteps) {
  const Recording sound = testing::realistic("drone_none", 20.0, 64);
  const Recording twice = with_gyro_step(sound, 7.0, {-0.01, 0.02, 0.01});
  for (const Eigen::Vector3d& step :
       {Eigen::Vector3d(0.05, 0, 0), Eigen::Vector3d(0, 0.02, 0), Eigen::Vector3d(0.01, 0, -0.05)}) {
    for (const Recording* recording : {&sound, &twice}) {
      const SensorOffsets offsets =
          beside_turned_mount(with_gyro_step(*recording, 13.4, step), Eigen::Vector3d::Zero());
      EXPECT_THAT(offset_mistakes(offsets), IsEmpty()) << step.transpose() << (recording == &twice);
      EXPECT_THAT(clock_mistakes(offsets), IsEmpty()) << step.transpose();
    }
  }
}

TEST(MountMistake, IsNamedByItsSizeBesideAGyroWhoseBiasSteps) {
  const Recording recording =
      with_gyro_step(testing::realistic("drone_none", 20.0, 65), 11.2, {0.03, -0.03, 0.02});
  const SensorOffsets offsets = beside_turned_mount(recording, {0.0, -0.8, 0.0});
  ASSERT_TRUE(offsets.mount);
  EXPECT_NEAR(kToDegrees * offsets.mount->turn.y(), 0.8, 0.15);
  EXPECT_THAT(offset_mistakes(offsets), ElementsAre(HasSubstr("cam0 is turned by")));
}

TEST(MountMistake, NeedsMoreOfALongLensAndOfFewSeconds) {
  const auto named = [](double degrees, double focal_widths, double dof) {
    SensorOffsets offsets;
    offsets.mount = MountTurn{Eigen::Vector3d(degrees / kToDegrees, 0, 0), 0.02 / kToDegrees, dof};
    offsets.focal_widths = focal_widths;
    return mount_mistake(offsets).has_value();
  };
  EXPECT_FALSE(named(0.39, 0.6, 20));
  EXPECT_TRUE(named(0.41, 0.6, 20));
  EXPECT_FALSE(named(0.6, 2.0, 20));
  EXPECT_TRUE(named(0.9, 2.0, 20));
  EXPECT_FALSE(named(0.41, 0.6, 1));
}

/// Lenses that turn the view with their length, by a factor too long: of both cameras.
SensorOffsets beside_focal_lengths(Recording recording, double factor) {
  for (Camera* camera : {&recording.calibration.cam0, &recording.calibration.cam1}) {
    camera->fu *= factor;
    camera->fv *= factor;
  }
  return sensor_offsets(recording.calibration, recording.frames, recording.imu);
}

SensorOffsets beside_scaled_gyro(Recording recording, const Eigen::Vector3d& factors) {
  for (ImuSample& sample : recording.imu) {
    sample.omega_imu = factors.cwiseProduct(sample.omega_imu);
  }
  return sensor_offsets(recording.calibration, recording.frames, recording.imu);
}

TEST(TurnScaleMistake, NamesAFocalLength) {
  for (const std::uint64_t seed : {57u, 58u}) {
    const Recording recording = testing::realistic("walk", 20.0, seed);
    for (const double factor : {1.02, 0.98}) {
      const SensorOffsets offsets = beside_focal_lengths(recording, factor);
      const auto scale = surest_scale(offsets);
      ASSERT_TRUE(scale);
      EXPECT_NEAR(scale->excess, 1.0 / factor - 1.0, 0.004) << seed << ' ' << factor;
      EXPECT_THAT(offset_mistakes(offsets),
                  ElementsAre(HasSubstr(factor > 1.0 ? "a focal length that is too long"
                                                     : "a focal length that is too short")))
          << seed << ' ' << factor << ' ' << offsets.confusion;
    }
  }
}

TEST(TurnScaleMistake, NamesAGyroAndItsAxis) {
  const Recording recording = testing::realistic("drone_none", 20.0, 59);
  const auto all = turn_scale_mistake(beside_scaled_gyro(recording, {1.03, 1.03, 1.03}));
  ASSERT_TRUE(all);
  EXPECT_THAT(all->words, HasSubstr("a scale of the gyro that is too large"));
  const auto one = turn_scale_mistake(beside_scaled_gyro(recording, {1.0, 1.0, 0.96}));
  ASSERT_TRUE(one);
  EXPECT_THAT(one->words, HasSubstr("a scale of the gyro's z axis that is too small"));
}

TEST(TurnScaleMistake, NeedsMoreWhereATurnLooksLikeAShift) {
  const auto named = [](double excess, double confusion, double dof) {
    SensorOffsets offsets;
    offsets.scales = {{TurnFactor::kGyro, excess, 1e-4, dof}};
    offsets.confusion = confusion;
    return turn_scale_mistake(offsets).has_value();
  };
  EXPECT_FALSE(named(0.004, 1.0, 20));
  EXPECT_TRUE(named(0.006, 1.0, 20));
  EXPECT_FALSE(named(0.011, 6.0, 20));
  EXPECT_TRUE(named(-0.013, 6.0, 20));
  EXPECT_FALSE(named(0.006, 1.0, 1));
  EXPECT_FALSE(named(0.5, std::numeric_limits<double>::infinity(), 20));
}

/// Depths are right, poses are not.
TEST(VerdictBesideMount, DegradesWhatIsOkAndNothingElse) {
  SensorOffsets offsets;
  offsets.mount = MountTurn{Eigen::Vector3d(0.01, 0, 0), 1e-4, 20.0};
  offsets.focal_widths = 0.6;
  EXPECT_EQ(verdict_beside(offsets, wrong_by(kOk, kOk)), kDegraded);
  EXPECT_EQ(verdict_beside(offsets, wrong_by(kOk, kDecalibrated)), kDecalibrated);
  EXPECT_EQ(verdict_beside(offsets, wrong_by(kOk, kCannotTell)), kCannotTell);
}

}  // namespace
}  // namespace limber
