// SPDX-License-Identifier: MIT
#include "limber/diagnose/run_answer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace limber {
namespace {

using enum HealthVerdict;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// A run of ten seconds that said `verdict` of its rig.
struct Said {
  RunOptions options;
  RunRecord record;
  RunSummary summary;

  explicit Said(HealthVerdict verdict) {
    for (std::int64_t k = 0; k <= 10; ++k) {
      TrajectoryRow row;
      row.t_ns = 1'000'000'000 * (5 + k);
      row.covariance = 1e-4 * Eigen::Matrix<double, 6, 6>::Identity();
      record.trajectory.push_back(row);
    }
    record.frames_of_recording = 40;
    summary.frames = record.trajectory.size();
    summary.health.emplace();
    summary.health->verdict = summary.health->present.verdict = verdict;
  }
  [[nodiscard]] RunAnswer answer() const { return answer_of(options, record, summary); }
};

TEST(RunAnswer, HasALightAHeadlineAndAdviceForEveryVerdict) {
  const auto expect = [](HealthVerdict verdict, AnswerLight light, const char* headline, const char* advice) {
    const RunAnswer answer = Said(verdict).answer();
    EXPECT_EQ(answer.light, light);
    EXPECT_EQ(answer.headline, headline);
    EXPECT_THAT(answer.advice, HasSubstr(advice));
  };
  expect(kOk, AnswerLight::kGreen, "calibration ok", "nothing");
  expect(kDegraded, AnswerLight::kYellow, "calibration degraded", "recalibrate when you can");
  expect(kDecalibrated, AnswerLight::kRed, "rig decalibrated", "recalibrate; until then");
  expect(kCannotTell, AnswerLight::kGrey, "cannot tell whether the calibration holds", "record more motion");
}

TEST(RunAnswer, SaysHowGoodThePosesAreAndWhetherTheFilterKnows) {
  Said said(kOk);
  said.summary.path_length_m = 30.5;
  said.summary.ate_se3_m = 0.0128;
  const auto poses = [&said](double anees) {
    said.summary.anees = anees;
    return said.answer().sentences.at(1);
  };
  EXPECT_EQ(poses(16.0),
            "poses: 0.0128 m from the truth (ATE after a rigid fit) on a path of 30.5 m, errors 4 times as "
            "large as the filter claims (ANEES 16)");
  EXPECT_THAT(poses(1.1), HasSubstr("about as large as the filter claims (ANEES 1.10)"));
  EXPECT_THAT(poses(0.1), HasSubstr("less than half as large"));
}

TEST(RunAnswer, WithoutTruthSaysWhatTheFilterClaims) {
  EXPECT_THAT(Said(kOk).answer().sentences,
              ElementsAre(HasSubstr("within the tolerance"),
                          HasSubstr("no truth is known; the filter claims 0.017 m and 0.99 deg")));
}

/// A sigma is a promise; this one rests on another.
TEST(RunAnswer, SaysWhatPositionsRestOnWhereTheLengthOfTheBaselineIsTrusted) {
  Said said(kOk);
  said.record.trajectory[7].T_world_body.p.x() = 20.0;
  said.summary.rests_on_length = true;
  EXPECT_EQ(
      said.answer().sentences.back(),
      "positions rest on the length of the baseline, which nothing here shows beside it: they are wrong "
      "by as many per cent as it is");
  said.record.motion = MotionModel::kConstantVelocity;
  said.record.pixel_noise = PixelNoiseReport{1.0, 0.9, 0.014};
  EXPECT_THAT(said.answer().sentences.back(),
              HasSubstr("as many per cent as it is; sigmas count 1.4 % (1σ) for what lenses may do"));
  said.record.motion = MotionModel::kImu;
  said.summary.scale_check = ScaleCheck{0, 0, {0.003, 0.012}};
  EXPECT_EQ(said.answer().sentences.back(),
            "positions rest on the length of the baseline, which the IMU shows to 1.2 % (1σ): 0.24 m at 20 m "
            "from the start, where 0.017 m are claimed");
  said.summary.scale_check = ScaleCheck{0, 0, {-0.09, 0.012}};
  EXPECT_EQ(
      said.answer().sentences.back(),
      "positions rest on the length of the baseline, which beside the IMU makes them 9 ± 1.2 % too short: "
      "1.8 m at 20 m from the start, where 0.017 m are claimed");
  EXPECT_EQ(said.answer().light, AnswerLight::kGreen) << "the depths say that the rig is ok";
}

/// The trusted length hides itself from the depths, and then only the scale shows it.
TEST(RunAnswer, DoubtsACalibrationWhoseLengthContradictsTheImuWhereDepthsCannotTell) {
  Said said(kCannotTell);
  said.summary.rests_on_length = true;
  said.summary.scale_check = ScaleCheck{0, 0, {0.02, 0.012}};
  EXPECT_EQ(said.answer().light, AnswerLight::kGrey);
  said.summary.scale_check = ScaleCheck{0, 0, {-0.09, 0.012}};
  EXPECT_EQ(said.answer().light, AnswerLight::kYellow);
  EXPECT_THAT(said.answer().headline, HasSubstr("another length than the IMU shows"));
  EXPECT_THAT(said.answer().advice, HasSubstr("--method lcekf or adaptive"));
}

/// KITTI drives were called ok with ANEES of 30 to 130.
TEST(RunAnswer, SaysWhatSigmasDoNotCountWhereOdometrysNoiseWasLearned) {
  Said said(kOk);
  const auto warns = [&] { return said.answer().sentences.back().starts_with("sigmas with odometry"); };
  said.record.motion = MotionModel::kOdometry;
  EXPECT_FALSE(warns()) << "noise was stated";
  said.record.odometry_noise.emplace();
  EXPECT_TRUE(warns());
  said.record.motion = MotionModel::kImu;
  EXPECT_FALSE(warns());
}

TEST(RunAnswer, SaysThatThePosesWereAlignedWithATruthThatIsNotLevel) {
  Said said(kOk);
  said.summary.ate_se3_m = 0.01;
  EXPECT_EQ(said.answer().sentences.size(), 2U);
  said.summary.truth_is_level = false;
  said.summary.truth_tilt_deg = 77.04;
  EXPECT_THAT(said.answer().sentences.at(2),
              AllOf(HasSubstr("not level"), HasSubstr("77.0 deg"), HasSubstr("of the aligned poses")));
}

/// Units, say: it was hidden behind what it had done.
TEST(RunAnswer, OfALostRunNamesTheMistakeThatMayBeWhy) {
  Said said(kOk);
  said.summary.mistakes = {"the accelerometer is in g"};
  said.summary.inputs.lost_since_ns = 7'500'000'000;
  const RunAnswer answer = said.answer();
  EXPECT_EQ(answer.headline, "looks like a mistake, lost since 2.5 s");
  EXPECT_EQ(answer.sentences.at(0), "the accelerometer is in g");
  EXPECT_THAT(answer.sentences.at(1), HasSubstr("nothing brought it back"));
  EXPECT_EQ(answer.advice, kMistakeAdvice);
}

TEST(RunAnswer, AdvisesToMendAClockThatIsOffWhateverTheRigIs) {
  Said said(kOk);
  said.summary.clock_mistakes = {"time offset: beside the IMU, the cameras are taken late"};
  EXPECT_EQ(said.answer().advice, kClockAdvice);
  said.summary.camera_imu_mistakes = {{"mount: cam0 is turned", kMountAdvice}};
  EXPECT_EQ(said.answer().advice, kClockAdvice) << "as limber health prints";
}

TEST(RunAnswer, SaysWhichClockWasCorrectedAndAdvisesAsWithout) {
  Said said(kOk);
  const RunAnswer without = said.answer();
  said.summary.corrected_clock = "time offset: late, which is corrected";
  EXPECT_THAT(said.answer().sentences, Contains("time offset: late, which is corrected"));
  EXPECT_EQ(said.answer().headline, without.headline);
  EXPECT_EQ(said.answer().advice, without.advice);
}

TEST(RunAnswer, OfPosesThatAreWorseThanTheyClaimIsRed) {
  Said said(kOk);
  said.summary.camera_imu_mistakes = {{"turns: more", kGyroScaleAdvice, true}};
  EXPECT_TRUE(is_trustworthy(said.summary));  // sigmas hold it
  EXPECT_NE(said.answer().light, AnswerLight::kRed);
  EXPECT_EQ(said.answer().advice, kGyroScaleAdvice);
  said.summary.camera_imu_mistakes.push_back({"inertial: a lever arm", kInertialAdvice, false});
  EXPECT_FALSE(is_trustworthy(said.summary));
  const RunAnswer answer = said.answer();
  EXPECT_EQ(answer.light, AnswerLight::kRed);
  EXPECT_EQ(answer.headline, "cameras and IMU contradict each other");
  EXPECT_EQ(answer.advice, kInertialAdvice);
  EXPECT_EQ(answer.sentences.at(1), "inertial: a lever arm") << "before what is said of the rig";
  said.summary.health->verdict = kDecalibrated;
  EXPECT_EQ(said.answer().headline, "cameras and IMU contradict each other, rig decalibrated");
}

TEST(RunAnswer, OfALostRunIsThatItIsLost) {
  Said said(kOk);
  said.summary.inputs.lost_since_ns = 7'500'000'000;
  const RunAnswer answer = said.answer();
  EXPECT_EQ(answer.light, AnswerLight::kRed);
  EXPECT_EQ(answer.headline, "lost since 2.5 s");
  EXPECT_THAT(answer.sentences.front(), HasSubstr("until then: calibration ok"));
  EXPECT_THAT(answer.advice, HasSubstr("no pose later than 2.5 s"));
}

TEST(RunAnswer, OfALostRunWhoseRigIsWrongSaysWhatToDoAboutIt) {
  Said said(kDecalibrated);
  const std::string recalibrate = said.answer().advice;
  said.summary.inputs.lost_since_ns = 7'500'000'000;
  const RunAnswer answer = said.answer();
  EXPECT_EQ(answer.headline, "lost since 2.5 s, rig decalibrated");
  EXPECT_THAT(answer.sentences.at(1), HasSubstr("not that of this rig"));
  EXPECT_THAT(answer.advice, AllOf(HasSubstr("no pose later than 2.5 s"), HasSubstr(recalibrate)));
}

TEST(RunAnswer, OfAStoppedRunSaysHowFarItCame) {
  Said said(kOk);
  said.record.stopped = true;
  EXPECT_THAT(said.answer().sentences.back(), HasSubstr("stopped after 11 of 40 frames"));
}

TEST(RunAnswer, SaysOfHowManyFramesTheImagesCouldNotBeRead) {
  Said said(kOk);
  EXPECT_THAT(said.answer().sentences.back(), Not(HasSubstr("could not be read")));
  said.record.frames_unreadable = 3;
  EXPECT_THAT(said.answer().sentences.back(), HasSubstr("the images of 3 of 40 frames could not be read"));
}

TEST(RunAnswer, JudgesNoRigThatWasNotWatched) {
  Said said(kOk);
  said.summary.health.reset();
  said.options.method = Method::kMonoLeft;
  const RunAnswer answer = said.answer();
  EXPECT_EQ(answer.light, AnswerLight::kGrey);
  EXPECT_EQ(answer.headline, "calibration not judged");
  EXPECT_THAT(answer.sentences.front(), HasSubstr("right camera"));
}

/// As the text and the exit code of limber health do.
TEST(RunAnswer, NamesAMistakeBeforeItJudgesARig) {
  Said said(kDecalibrated);
  said.summary.mistakes = {"gyro in deg/s"};
  EXPECT_EQ(said.answer().headline, "looks like a mistake");
  EXPECT_EQ(said.answer().sentences.front(), "gyro in deg/s");
  EXPECT_EQ(said.answer().light, AnswerLight::kRed);
  EXPECT_THAT(said.answer().advice, HasSubstr("mend the mistake"));
}

TEST(RunAnswer, SaysWhichClockIsOff) {
  Said said(kDecalibrated);
  said.summary.health->present.axes[1] = kDecalibrated;
  add_offsets({.cam1 = TimeOffset{.seconds = 0.03, .sigma = 0.001}, .cameras = {}}, said.summary);
  EXPECT_EQ(said.answer().headline, "cannot tell whether the calibration holds");
  EXPECT_THAT(said.answer().sentences.front(), HasSubstr("cam1 is taken 30.0"));
}

TEST(RunAnswer, SaysThatAMountIsTurned) {
  Said said(kOk);
  SensorOffsets offsets;
  offsets.mount = MountTurn{Eigen::Vector3d(0.01, 0.0, 0.0), 1e-4, 20.0};
  offsets.focal_widths = 0.6;
  add_offsets(offsets, said.summary);
  EXPECT_EQ(said.answer().headline, "cameras and IMU contradict each other");
  EXPECT_FALSE(is_trustworthy(said.summary));
  EXPECT_THAT(said.answer().sentences.front(), HasSubstr("cam0 is turned by 0.57"));
  EXPECT_THAT(said.answer().advice, HasSubstr("--estimate imu-ax"));
}

TEST(RunAnswer, DoesNotJudgeARigWhoseRowsAreExposedOtherwise) {
  Said said(kDecalibrated);
  said.summary.readout_contradicted = true;
  said.record.notes = {"the rows take 20 ms"};
  const RunAnswer answer = said.answer();
  EXPECT_EQ(answer.light, AnswerLight::kGrey);
  EXPECT_EQ(answer.sentences.front(), "the rows take 20 ms");
  EXPECT_THAT(answer.advice, HasSubstr("--readout-time"));
  EXPECT_THAT(answer.headline, Not(HasSubstr("decalibrated")));
}

}  // namespace
}  // namespace limber
