// SPDX-License-Identifier: MIT
#include "limber/run/run_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <stdexcept>
#include <utility>

#include "limber/datasets/interpolate.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "message_of.hpp"
#include "run/recorded_run.hpp"
#include "run/short_recording.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using testing::expect_sound;
using testing::from_truth;
using ::testing::HasSubstr;
using testing::last_error;
using testing::message_of;
using ::testing::Not;
using testing::run;
using testing::same_run;
using testing::short_recording;
using testing::short_scenario;
using testing::vision_only;
using testing::without_imu;

class EveryMethod : public ::testing::TestWithParam<Method> {};

TEST_P(EveryMethod, GivesAPoseWithASoundCovarianceForEveryFrame) {
  const Recording recording = short_recording();
  const RunRecord record = run(recording, from_truth(GetParam()));
  expect_sound(record, recording.frames.size());
  EXPECT_FALSE(record.landmarks.empty());
  EXPECT_EQ(record.motion, MotionModel::kImu);
  // Two seconds of IMU alone (0.1 m/s^2, 0.5 deg/s a sample) stay within this; a run that went wrong does
  // not.
  EXPECT_LT(last_error(recording, record), 0.2);
}

TEST_P(EveryMethod, GivesTheSameBitsTwice) {
  const Recording recording = short_recording();
  const RunOptions options = from_truth(GetParam());
  EXPECT_TRUE(same_run(run(recording, options), run(recording, options)));
}

std::string test_name(const ::testing::TestParamInfo<Method>& method) {
  std::string name = to_string(method.param);
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(RunRecording, EveryMethod, ::testing::ValuesIn(kAllMethods), test_name);

RunRecord run_alone(const Recording& recording, Method method) {
  RunOptions options;
  options.method = method;
  return run(recording, options);
}

void expect_shared(const Recording& recording, Method method, const RunRecord& alone, SharedStarts& starts) {
  RunOptions options;
  options.method = method;
  const RunRecord shared = run_recording(recording, options, matched_frames(recording), {}, &starts);
  EXPECT_TRUE(same_run(alone, shared)) << to_string(method);
  EXPECT_EQ(shared.notes, alone.notes) << to_string(method);
  EXPECT_EQ(shared.sensor_start->scale_sigma, alone.sensor_start->scale_sigma) << to_string(method);
  EXPECT_EQ(shared.cleaning.frames, alone.cleaning.frames) << to_string(method);
  EXPECT_EQ(shared.cleaning.leapt_matches, alone.cleaning.leapt_matches) << to_string(method);
}

TEST(RunRecording, OfASharedStartIsBitByBitThatOfItsOwn) {
  Scenario scenario = short_scenario();
  set_pixels(scenario, PixelPreset::kRealistic);
  const Recording recording = simulate(scenario, 1);
  SharedStarts starts;
  for (const Method method :
       {Method::kEkf, Method::kLcekf, Method::kEkfFull, Method::kAdaptive, Method::kMonoLeft}) {
    expect_shared(recording, method, run_alone(recording, method), starts);
  }
  EXPECT_EQ(starts.size(), 2u)
      << "of those that leave theta open (ekf, as its pixels are not stated), of mono-left";
}

TEST(RunRecording, SmoothsItsStartByTheFramesBehindItOnAnyNumberOfThreads) {
  Scenario scenario = short_scenario();
  set_pixels(scenario, PixelPreset::kRealistic);
  const Recording recording = simulate(scenario, 1);
  RunOptions options;
  options.method = Method::kEkf;
  const RunRecord in_turn = run(recording, options);
  options.threads = 2;
  EXPECT_TRUE(same_run(in_turn, run(recording, options)));
  std::vector<TrajectoryRow> observed;
  const auto observe = [&](const ObservedFrame& frame) { observed.push_back(frame.row); };
  const RunRecord watched =
      run_recording(recording, options, matched_frames(recording), {.observe = observe});
  EXPECT_TRUE(same_run(in_turn, watched));
  const std::size_t last = in_turn.frames_of_start - 1;
  ASSERT_EQ(in_turn.trajectory[last].t_ns, in_turn.start.nav.t_ns);
  const double handed_over = in_turn.start.body_covariance.diagonal().head(6).sum();
  EXPECT_LT(in_turn.trajectory[last].covariance->trace(), 0.9 * handed_over);
  EXPECT_EQ(observed[0].T_world_body.p, in_turn.trajectory[0].T_world_body.p);
  EXPECT_EQ(*observed[last].covariance, *in_turn.trajectory[last].covariance);
}

TEST(RunRecording, SmoothsASharedStartAnewWhereTheRunBeforeFailed) {
  Scenario sound = testing::shipped("drone_none", 4.5);
  const Recording recording = simulate(sound, 1);
  SharedStarts starts;
  RunOptions options;
  options.method = Method::kAdaptive;
  options.threads = 2;
  const auto fail = [&](std::size_t n) {
    if (n + 2 > recording.frames.size()) throw std::runtime_error("failed");
  };
  EXPECT_THROW(
      (void)run_recording(recording, options, matched_frames(recording), {.progress = fail}, &starts),
      std::runtime_error);
  expect_shared(recording, Method::kLcekf, run_alone(recording, Method::kLcekf), starts);
}

TEST(RunRecording, OfAdaptiveWhichTrustsTheRigSharesItsStartWithThoseThatDoNot) {
  Scenario sound = testing::shipped("drone_none", 4.5);
  const Recording recording = simulate(sound, 1);
  const RunRecord lcekf = run_alone(recording, Method::kLcekf);
  const RunRecord adaptive = run_alone(recording, Method::kAdaptive);
  ASSERT_TRUE(adaptive.start.distrusting);
  EXPECT_NE(adaptive.start.nav.T_world_body.p, lcekf.start.nav.T_world_body.p);
  EXPECT_LT(adaptive.sensor_start->scale_sigma, 0.8 * lcekf.sensor_start->scale_sigma);
  SharedStarts starts, starts_of_adaptive;
  expect_shared(recording, Method::kLcekf, lcekf, starts);
  expect_shared(recording, Method::kAdaptive, adaptive, starts);
  expect_shared(recording, Method::kAdaptive, adaptive, starts_of_adaptive);
  expect_shared(recording, Method::kLcekf, lcekf, starts_of_adaptive);
  EXPECT_EQ(starts.size() + starts_of_adaptive.size(), 2u);
}

TEST(RunRecording, DrawsAnotherStartForAnotherSeedOrRun) {
  const Recording recording = short_recording();
  RunOptions options = from_truth();
  const RunRecord first = run(recording, options);
  options.seed = 1;
  EXPECT_FALSE(same_run(first, run(recording, options)));
  options.seed = 0;
  options.run = 1;
  EXPECT_FALSE(same_run(first, run(recording, options)));
}

TEST(RunRecording, StartsFromSensorsAloneWithoutLookingAtTheTruth) {
  Recording recording = short_recording();
  const RunRecord with_truth = run(recording, {});
  expect_sound(with_truth, recording.frames.size());
  recording.truth.motion.states.clear();
  recording.truth.landmarks.clear();
  recording.truth.rig.clear();
  EXPECT_TRUE(same_run(with_truth, run(recording, {})));
}

TEST(RunRecording, SkipsFramesBeforeTheFirstImuSampleAndSaysSo) {
  Recording recording = short_recording();
  std::erase_if(recording.imu, [](const ImuSample& s) { return s.t_ns < 480'000'000; });
  const RunRecord record = run(recording, {});
  expect_sound(record, recording.frames.size() - 10);
  EXPECT_EQ(record.trajectory.front().t_ns, 500'000'000);
  EXPECT_THAT(record.notes, Contains(HasSubstr("10 frames skipped: before the first input")));
}

/// The frames of the start used to count as dead reckoning, and the samples of its window as late.
TEST(RunRecording, SaysOfAStartFromSoundSensorsNothingThatIsNotTrue) {
  const RunRecord record = run(short_recording(), {});
  for (const FrameReport& frame : record.frames) {
    EXPECT_EQ(frame.status, UpdateStatus::kUpdated) << frame.t_ns;
    EXPECT_GT(frame.used, 0U) << frame.t_ns;
    EXPECT_EQ(frame.inputs.faults[InputFault::kLate], 0U) << frame.t_ns;
  }
  EXPECT_THAT(record.notes, Not(Contains(HasSubstr("dead reckoning"))));
  EXPECT_THAT(record.notes, Not(Contains(HasSubstr("late"))));
}

/// What came before the filter was not judged: of a car's 30 s the first eleven, and a rig that changed soon
/// after them had no "before".
TEST(RunRecording, JudgesTheRigByTheFramesOfItsStart) {
  Scenario scenario = short_scenario();
  scenario.duration = 4.0;
  const Recording recording = simulate(scenario, 1);
  for (const Method method : {Method::kLcekf, Method::kEkf}) {
    RunOptions options;
    options.method = method;
    const RunRecord record = run(recording, options);
    ASSERT_GT(record.frames_of_start, 10U);
    EXPECT_TRUE(record.frames[record.frames_of_start - 1].calibration);
    ASSERT_TRUE(record.frames.back().calibration);
    EXPECT_EQ(record.frames.back().calibration->state.from_ns, record.frames.front().t_ns);
  }
}

TEST(RunRecording, SkipsFramesBeforeTheGroundTruthThatItStartsFrom) {
  Recording recording = short_recording();
  std::erase_if(recording.truth.motion.states,
                [](const GroundTruthState& s) { return s.t_ns < 280'000'000; });
  const RunRecord record = run(recording, from_truth());
  EXPECT_EQ(record.trajectory.front().t_ns, 300'000'000);
  EXPECT_THAT(record.notes, Contains(HasSubstr("6 frames skipped: before the first input or ground truth")));
}

TEST(RunRecording, RefusesARecordingWhoseInputsComeAfterAllFrames) {
  Recording recording = short_recording();
  std::erase_if(recording.frames, [](const StereoFrame& f) { return f.t_ns > 400'000'000; });
  std::erase_if(recording.imu, [](const ImuSample& s) { return s.t_ns < 480'000'000; });
  EXPECT_THAT(
      message_of([&] { (void)run(recording, {}); }),
      HasSubstr("the frames cover 0.000 s to 0.400 s, the IMU 0.480 s to 2.000 s; do they have the same"));
}

TEST(RunRecording, RefusesARecordingWhoseInputsEndBeforeAllFrames) {
  Recording recording = short_recording();
  std::erase_if(recording.frames, [](const StereoFrame& f) { return f.t_ns < 400'000'000; });
  std::erase_if(recording.imu, [](const ImuSample& s) { return s.t_ns >= 300'000'000; });
  EXPECT_THAT(message_of([&] { (void)run(recording, {}); }), HasSubstr("the IMU 0.000 s to 0.290 s"));
}

TEST(RunRecording, SaysWhereTheImuHasNoSamples) {
  Recording recording = short_recording();
  std::erase_if(recording.imu, [](const ImuSample& s) {
    return (s.t_ns > 500'000'000 && s.t_ns < 900'000'000) || s.t_ns > 1'800'000'000;
  });
  EXPECT_THAT(
      run(recording, {}).notes,
      Contains("the IMU has no sample for 0.40 s from 0.500 s on, and 1 more such gaps: the motion there "
               "is guessed"));
  EXPECT_THAT(run(short_recording(), {}).notes, Not(Contains(HasSubstr("guessed"))));
}

TEST(RunRecording, SaysWhereNoFrameCameAndWhereTheRightCameraSawNothing) {
  const auto blind = HasSubstr("the right camera saw no point for 1.0"),
             silent = HasSubstr("no frame came for");
  EXPECT_THAT(run(short_recording(), {}).notes, AllOf(Not(Contains(blind)), Not(Contains(silent))));
  Recording recording = short_recording();
  for (StereoFrame& frame : recording.frames) {
    for (StereoObservation& point : frame.observations) {
      point.in_cam1 = frame.t_ns < 1'000'000'000;
    }
  }
  EXPECT_THAT(run(recording, from_truth()).notes, Contains(blind)) << "to the end";
  recording = short_recording();
  std::erase_if(recording.frames,
                [](const StereoFrame& f) { return f.t_ns > 500'000'000 && f.t_ns < 1'700'000'000; });
  EXPECT_THAT(run(recording, from_truth()).notes,
              Contains(HasSubstr("no frame came for 1.20 s from 0.500 s on")));
}

TEST(RunRecording, DoubtsAnAccelerometerThatDoesNotShowGravity) {
  Recording recording = short_recording();
  for (ImuSample& sample : recording.imu) {
    sample.accel_imu /= 9.81;
  }
  const auto notes = run(recording, {}).notes;
  EXPECT_THAT(notes, Contains(HasSubstr("the accelerometer shows 1.0")));
  EXPECT_THAT(run(short_recording(), {}).notes, Not(Contains(HasSubstr("shows"))));
}

TEST(RunRecording, SaysWhereTheMeasurementsContradictTheModel) {
  RunOptions options = from_truth();
  EXPECT_THAT(run(short_recording(), options).notes, Not(Contains(HasSubstr("NIS"))));
  options.sigma_px = 0.1;  // 0.5 in truth
  EXPECT_THAT(run(short_recording(), options).notes, Contains(HasSubstr("NIS per degree of freedom is")));
}

TEST(RunRecording, OfSamplesThatNoSensorCanShowNoneIsUsed) {
  Recording recording = short_recording();
  for (ImuSample& sample : recording.imu) {
    sample.omega_imu.x() += 20.0;
    sample.accel_imu *= 1e12;
  }
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  const RunRecord record = run(recording, options);
  EXPECT_THAT(record.notes, Contains(HasSubstr("input samples were impossible: left out")));
  EXPECT_THAT(record.notes,
              Contains(HasSubstr("the gyroscope shows 20 rad/s on average: is its unit rad/s?")));
  EXPECT_EQ(record.frames.back().inputs.status, InputStatus::kNone);
}

TEST(RunRecording, TakesWhatShakesABodyForNoWrongUnit) {
  Recording recording = short_recording();
  const auto question = Contains(HasSubstr("its unit m/s^2?"));
  double sign = 20.0;  // [m/s^2]
  for (ImuSample& sample : recording.imu) {
    sample.accel_imu.z() += std::exchange(sign, -sign);
  }
  EXPECT_THAT(run(recording, from_truth()).notes, Not(question));
  for (ImuSample& sample : recording.imu) {
    sample.accel_imu *= 0.1;  // in units of some ten
  }
  EXPECT_THAT(run(recording, from_truth()).notes, question);
}

TEST(RunRecording, AStudysRunEndsWhereTheFilterBreaksDown) {
  Recording recording = short_recording();
  for (ImuSample& sample : recording.imu) {
    sample.accel_imu *= 500.0;  // 500 g: no sensor fault by itself, faster than anything after a second
  }
  for (StereoFrame& frame : recording.frames) {
    frame.observations.clear();
  }
  RunOptions options;
  options.start = StartMode::kGroundTruth;
  const RunRecord record = run(recording, options);
  EXPECT_THAT(record.notes, Contains(HasSubstr("the run is lost since")));
  options.stop_when_lost = true;
  try {
    (void)run(recording, options);
    FAIL() << "did not diverge";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("lcekf diverged at frame "));
  }
}

TEST(RunRecording, SaysThatNoErrorsAreKnownWhereTheTruthIsOfAnotherTime) {
  Recording recording = short_recording();
  for (GroundTruthState& state : recording.truth.motion.states) {
    state.t_ns += 1'000'000'000'000;
  }
  EXPECT_THAT(
      run(recording, {}).notes,
      Contains("ground truth covers 1000.000 s to 1002.000 s, the frames 0.000 s to 2.000 s: no errors are "
               "known"));
}

TEST(RunRecording, SaysWhichCameraSawNothing) {
  Recording blind = short_recording(), left = blind, right = blind;
  for (std::size_t k = 0; k < blind.frames.size(); ++k) {
    blind.frames[k].observations.clear();
    for (StereoObservation& point : left.frames[k].observations) {
      point.in_cam1 = false;
    }
    for (StereoObservation& point : right.frames[k].observations) {
      point.in_cam0 = false;
    }
  }
  EXPECT_THAT(run(blind, {}).notes, Contains(HasSubstr("dead reckoning")));
  EXPECT_THAT(run(right, {}).notes, Contains(HasSubstr("dead reckoning")));
  EXPECT_THAT(run(left, {}).notes, Contains(HasSubstr("the left camera alone")));
  RunOptions mono;
  mono.method = Method::kMonoLeft;
  EXPECT_THAT(run(left, mono).notes, Not(Contains(HasSubstr("the left camera alone"))));
}

TEST(RunRecording, RunsOnOdometryAlone) {
  const Recording recording = without_imu(short_recording());
  for (const StartMode start : {StartMode::kAuto, StartMode::kGroundTruth}) {
    RunOptions options;
    options.start = start;
    const RunRecord record = run(recording, options);
    expect_sound(record, recording.frames.size());
    EXPECT_EQ(record.motion, MotionModel::kOdometry);
    EXPECT_FALSE(record.trajectory.back().bias_gyro);
  }
  EXPECT_LT(last_error(recording, run(recording, from_truth())), 0.2);
}

TEST(RunRecording, RunsOnVisionAlone) {
  const Recording recording = vision_only(short_recording());
  for (const StartMode start : {StartMode::kAuto, StartMode::kGroundTruth}) {
    RunOptions options;
    options.start = start;
    const RunRecord record = run(recording, options);
    expect_sound(record, recording.frames.size());
    EXPECT_EQ(record.motion, MotionModel::kConstantVelocity);
  }
  EXPECT_LT(last_error(recording, run(recording, from_truth())), 0.5);
}

}  // namespace
}  // namespace limber
