// SPDX-License-Identifier: MIT
#include "limber/run/run_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <stdexcept>

#include "limber/datasets/interpolate.hpp"
#include "message_of.hpp"
#include "run/short_recording.hpp"

namespace limber {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::message_of;
using ::testing::Not;
using testing::short_recording;
using testing::vision_only;
using testing::without_imu;

RunOptions from_truth(Method method = Method::kLcekf) {
  RunOptions options;
  options.method = method;
  options.start = StartMode::kGroundTruth;
  return options;
}

RunRecord run(const Recording& recording, const RunOptions& options) {
  return run_recording(recording, options, matched_frames(recording));
}

void expect_sound(const RunRecord& record, std::size_t frames) {
  ASSERT_EQ(record.trajectory.size(), frames);
  EXPECT_EQ(record.frames.size(), frames);
  EXPECT_EQ(record.frame_ms.size(), frames);
  EXPECT_EQ(record.source_ms.size(), frames);
  for (std::size_t k = 0; k < frames; ++k) {
    const auto& P = record.trajectory[k].covariance.value();
    EXPECT_EQ(P, P.transpose());
    EXPECT_EQ(P.llt().info(), Eigen::Success) << k;
    EXPECT_EQ(record.trajectory[k].t_ns, record.frames[k].t_ns);
  }
}

double last_error(const Recording& recording, const RunRecord& record) {
  const TrajectoryRow& last = record.trajectory.back();
  const GroundTruthState truth = groundtruth_at(recording.truth.motion.states, last.t_ns).value();
  return (truth.p_world_body - last.T_world_body.p).norm();
}

bool same(const RunRecord& a, const RunRecord& b) {
  bool equal = a.trajectory.size() == b.trajectory.size() && a.landmarks == b.landmarks && a.theta == b.theta;
  for (std::size_t k = 0; equal && k < a.trajectory.size(); ++k) {
    const TrajectoryRow &x = a.trajectory[k], &y = b.trajectory[k];
    equal = x.t_ns == y.t_ns && x.T_world_body.p == y.T_world_body.p &&
            x.T_world_body.R == y.T_world_body.R && x.v_world_body == y.v_world_body &&
            x.bias_gyro == y.bias_gyro && x.bias_accel == y.bias_accel && x.covariance == y.covariance &&
            a.frames[k].nis == b.frames[k].nis;
  }
  return equal;
}

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
  EXPECT_TRUE(same(run(recording, options), run(recording, options)));
}

std::string test_name(const ::testing::TestParamInfo<Method>& method) {
  std::string name = to_string(method.param);
  std::erase(name, '-');
  return name;
}

INSTANTIATE_TEST_SUITE_P(RunRecording, EveryMethod, ::testing::ValuesIn(kAllMethods), test_name);

TEST(RunRecording, DrawsAnotherStartForAnotherSeedOrRun) {
  const Recording recording = short_recording();
  RunOptions options = from_truth();
  const RunRecord first = run(recording, options);
  options.seed = 1;
  EXPECT_FALSE(same(first, run(recording, options)));
  options.seed = 0;
  options.run = 1;
  EXPECT_FALSE(same(first, run(recording, options)));
}

TEST(RunRecording, StartsFromSensorsAloneWithoutLookingAtTheTruth) {
  Recording recording = short_recording();
  const RunRecord with_truth = run(recording, {});
  expect_sound(with_truth, recording.frames.size());
  recording.truth.motion.states.clear();
  recording.truth.landmarks.clear();
  recording.truth.rig.clear();
  EXPECT_TRUE(same(with_truth, run(recording, {})));
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

TEST(RunRecording, AsksForEachFrameOnceAndInOrderAndTellsTheProgress) {
  const Recording recording = short_recording();
  for (const StartMode start : {StartMode::kAuto, StartMode::kGroundTruth}) {
    std::vector<std::size_t> asked, told, expected_asked, expected_told;
    for (std::size_t n = 0; n < recording.frames.size(); ++n) {
      expected_asked.push_back(n);
      expected_told.push_back(n + 1);
    }
    RunOptions options;
    options.start = start;
    (void)run_recording(recording, options,
                        [&](std::size_t n) {
                          asked.push_back(n);
                          return recording.frames[n];
                        },
                        {.progress = [&](std::size_t n) { told.push_back(n); }});
    EXPECT_EQ(asked, expected_asked);
    EXPECT_EQ(told, expected_told);
  }
}

TEST(RunRecording, TellsTheOracleTheTruthAndNobodyElse) {
  const Recording recording = short_recording();
  const RigParameters truth = recording.truth.rig.back().theta;
  EXPECT_EQ(run(recording, from_truth(Method::kOracle)).theta, truth);
  EXPECT_EQ(run(recording, from_truth(Method::kEkf)).theta, recording.calibration.theta);
  EXPECT_EQ(run(recording, from_truth(Method::kLcekf)).theta, recording.calibration.theta);
}

TEST(RunRecording, ForgetsPointsOutOfViewBeyondTheLimitOfTheMap) {
  const Recording recording = short_recording();
  RunOptions options = from_truth();
  EXPECT_GT(run(recording, options).landmarks.size(), recording.frames.back().observations.size());
  options.max_landmarks = 1;
  EXPECT_LE(run(recording, options).landmarks.size(), recording.frames.back().observations.size());
}

TEST(RunRecording, TellsAnObserverOfEveryFrameAndEndsWhenItThrows) {
  const Recording recording = short_recording();
  std::vector<std::int64_t> times;
  struct Enough {};
  const auto observe = [&](const ObservedFrame& frame) {
    ASSERT_NE(frame.navigator, nullptr);
    EXPECT_EQ(frame.report.t_ns, frame.navigator->estimate().nav().t_ns);
    EXPECT_EQ(frame.report.t_ns, frame.row.t_ns);
    times.push_back(frame.report.t_ns);
    if (times.size() == 5) {
      throw Enough();
    }
  };
  EXPECT_THROW((void)run_recording(recording, from_truth(), matched_frames(recording), {.observe = observe}),
               Enough);
  ASSERT_EQ(times.size(), 5u);
  EXPECT_EQ(times.back(), recording.frames[4].t_ns);
}

TEST(RunRecording, TellsAlsoOfTheFramesThatAStartFromTheSensorsHasUsedUp) {
  const Recording recording = short_recording();
  RunOptions options = from_truth();
  options.start = StartMode::kAuto;
  std::vector<std::int64_t> times;
  std::size_t filtered = 0;
  const auto observe = [&](const ObservedFrame& frame) {
    times.push_back(frame.row.t_ns);
    filtered += frame.navigator != nullptr ? 1 : 0;
    EXPECT_TRUE(filtered == 0 || frame.navigator != nullptr);
  };
  const RunRecord record = run_recording(recording, options, matched_frames(recording), {.observe = observe});
  ASSERT_EQ(times.size(), record.trajectory.size());
  for (std::size_t k = 0; k < times.size(); ++k) {
    EXPECT_EQ(times[k], record.trajectory[k].t_ns);
  }
  ASSERT_TRUE(record.sensor_start);
  const auto until_started = static_cast<double>(times[times.size() - filtered - 1] - times.front());
  EXPECT_NEAR(1e-9 * until_started, record.sensor_start->waited_s, 1e-9);
  EXPECT_GT(record.sensor_start->waited_s, 0.0);
}

TEST(RunRecording, TellsOfEveryFrameWhileAStartFromTheSensorsWaitsAndWhatItWaitsFor) {
  const Recording recording = short_recording();
  RunOptions options;
  options.method = Method::kEkf;  // knows the scale after one of the two seconds
  std::vector<std::int64_t> waited, done;
  RunCallbacks callbacks;
  callbacks.wait = [&](const WaitingFrame& frame) {
    EXPECT_TRUE(done.empty());
    EXPECT_EQ(frame.report.status, StartStatus::kWaiting);
    EXPECT_FALSE(frame.report.missing.empty());
    waited.push_back(frame.frame.t_ns);
    EXPECT_EQ(frame.number, waited.size());
    EXPECT_NEAR(frame.report.waited_s, 1e-9 * static_cast<double>(waited.back() - waited.front()), 1e-9);
  };
  callbacks.observe = [&](const ObservedFrame& frame) { done.push_back(frame.row.t_ns); };
  (void)run_recording(recording, options, matched_frames(recording), callbacks);
  ASSERT_GT(waited.size(), 5u);
  ASSERT_GT(done.size(), waited.size());
  EXPECT_TRUE(std::equal(waited.begin(), waited.end(), done.begin()));
}

TEST(RunRecording, LeavesTheFilterTheEndOfAShortRecordingWhoseScaleNobodyKnows) {
  Scenario scenario = testing::short_scenario();
  scenario.duration = 3.0;
  const Recording recording = simulate(scenario, 1);
  const RunRecord record = run(recording, {});
  expect_sound(record, recording.frames.size());
  ASSERT_TRUE(record.sensor_start);
  EXPECT_EQ(record.sensor_start->status, StartStatus::kTimedOut);
  EXPECT_NEAR(record.sensor_start->waited_s, 2.0, 0.06);
  EXPECT_THAT(record.notes, Contains(HasSubstr("no acceleration yet that tells the scale")));
}

TEST(RunRecording, StoppedWhileAStartWaitsKeepsTheFramesSoFar) {
  const Recording recording = short_recording();
  for (const std::size_t kept : {std::size_t{0}, std::size_t{4}}) {
    std::size_t asked = 0;
    const RunRecord record =
        run_recording(recording, {}, matched_frames(recording), {.stop = [&] { return asked++ >= kept; }});
    EXPECT_TRUE(record.stopped);
    EXPECT_EQ(record.frames.size(), kept);
    EXPECT_EQ(record.trajectory.size(), kept);
    EXPECT_EQ(asked, kept + 1);
  }
}

TEST(RunRecording, DrawsTheStartErrorFromWhatItIsToldWhateverTheEstimatorAssumes) {
  const Recording recording = short_recording();
  const auto first_error = [&](double drawn, double assumed) {
    RunOptions options = from_truth();
    options.initial.position = assumed;
    options.initial_error = options.initial;
    options.initial_error->position = drawn;
    double error = 0.0;
    const auto observe = [&](const ObservedFrame& frame) {
      if (frame.report.t_ns == 0) {
        error = (frame.row.T_world_body.p - recording.truth.motion.states.front().p_world_body).norm();
      }
    };
    (void)run_recording(recording, options, matched_frames(recording), {.observe = observe});
    return error;
  };
  // Nothing can tell where the world's origin is: the error of the start stays.
  EXPECT_GT(first_error(1.0, 1e-3), 0.1);
  EXPECT_LT(first_error(1e-3, 1.0), 0.1);
}

}  // namespace
}  // namespace limber
