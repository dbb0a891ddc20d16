// SPDX-License-Identifier: MIT
// What a run asks for and tells meanwhile, and how a start from the sensors shows.
#include "limber/run/run_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <stdexcept>

#include "limber/datasets/interpolate.hpp"
#include "message_of.hpp"
#include "run/recorded_run.hpp"
#include "run/short_recording.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using testing::expect_sound;
using testing::from_truth;
using ::testing::HasSubstr;
using testing::run;
using testing::short_recording;

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
