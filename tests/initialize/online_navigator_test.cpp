// SPDX-License-Identifier: MIT
#include "limber/initialize/online_navigator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "feed.hpp"
#include "message_of.hpp"
#include "navigate/scene.hpp"
#include "started.hpp"

namespace limber {
namespace {

using testing::Feed;
using ::testing::HasSubstr;
using testing::kMs;
using testing::make_scene;
using testing::message_of;
using testing::of_seed;
using testing::options_of;
using testing::Scene;
using testing::SceneOptions;
using testing::soon;

struct Passed {
  std::vector<OnlineReport> reports;
  std::vector<Estimate> estimates;  // once started
};

/// Frames of a scene, the first of them on.
Passed pass(OnlineNavigator& navigator, const Scene& scene, std::size_t first = 0,
            std::size_t end = std::numeric_limits<std::size_t>::max()) {
  Passed out;
  Feed feed{scene};
  for (std::size_t k = first; k < std::min(end, scene.frames.size()); ++k) {
    feed.until(navigator, scene.frames[k].t_ns);
    out.reports.push_back(navigator.process(scene.frames[k]));
    if (navigator.started()) {
      out.estimates.push_back(navigator.estimate());
    }
  }
  return out;
}

/// The same by hand: a SensorStart, then a Navigator that has all samples.
std::vector<Estimate> by_hand(const Scene& scene, const NavigatorOptions& options) {
  SensorStart start(options, scene.calibration, soon());
  Feed to_start{scene}, to_navigator{scene};
  std::optional<Navigator> navigator;
  std::vector<Estimate> out;
  for (const StereoFrame& frame : scene.frames) {
    if (!navigator) {
      to_start.until(start, frame.t_ns);
      if (start.add_frame(frame).status == StartStatus::kWaiting) {
        continue;
      }
      navigator.emplace(options, scene.calibration, start.result().initial);
      if (options.motion != MotionModel::kOdometry) {
        out.push_back(navigator->estimate());
        continue;
      }
    }
    to_navigator.until(*navigator, frame.t_ns);
    navigator->process(frame);
    out.push_back(navigator->estimate());
  }
  return out;
}

void expect_same_bits(const std::vector<Estimate>& a, const std::vector<Estimate>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].nav().t_ns, b[k].nav().t_ns);
    EXPECT_EQ(a[k].nav().T_world_body.p, b[k].nav().T_world_body.p);
    EXPECT_EQ(a[k].nav().T_world_body.R, b[k].nav().T_world_body.R);
    EXPECT_EQ(a[k].P().dense(), b[k].P().dense());
  }
}

Scene scene_with(MotionModel motion, double duration_s = 2.0) {
  SceneOptions options = of_seed(1);
  options.motion = motion;
  options.duration_s = duration_s;
  return make_scene(options);
}

class OnlineNavigatorBy : public ::testing::TestWithParam<MotionModel> {};

INSTANTIATE_TEST_SUITE_P(Motion, OnlineNavigatorBy,
                         ::testing::Values(MotionModel::kImu, MotionModel::kOdometry,
                                           MotionModel::kConstantVelocity));

TEST_P(OnlineNavigatorBy, IsTheStartAndThenTheNavigatorBitByBit) {
  const Scene scene = scene_with(GetParam());
  for (const Method method : {Method::kEkf, Method::kLcekf, Method::kAdaptive}) {
    NavigatorOptions options = options_of(scene, method);
    if (!has_scale(options.motion)) {
      options.constraints.kind = ConstraintSet::Kind::kRotationDirection;
    }
    OnlineNavigator navigator(options, scene.calibration, soon());
    const Passed passed = pass(navigator, scene);
    EXPECT_GT(passed.estimates.size(), 15U);
    expect_same_bits(passed.estimates, by_hand(scene, options));
  }
}

TEST(OnlineNavigator, SaysWhatItWaitsForThenThatItStartsThenWhatTheFilterMadeOfTheFrame) {
  const Scene scene = scene_with(MotionModel::kImu);
  OnlineNavigator navigator(options_of(scene, Method::kLcekf), scene.calibration, soon());
  const Passed passed = pass(navigator, scene);
  std::size_t k = 0;
  for (; passed.reports[k].start->status == StartStatus::kWaiting; ++k) {
    EXPECT_FALSE(passed.reports[k].start->missing.empty());
    EXPECT_FALSE(passed.reports[k].frame);
  }
  EXPECT_EQ(k, passed.reports.size() - passed.estimates.size());
  EXPECT_FALSE(passed.reports[k].frame) << "the start has used it up";
  for (++k; k < passed.reports.size(); ++k) {
    EXPECT_EQ(passed.reports[k].t_ns, scene.frames[k].t_ns);
    EXPECT_FALSE(passed.reports[k].start);
    ASSERT_TRUE(passed.reports[k].frame);
    EXPECT_EQ(passed.reports[k].frame->status, UpdateStatus::kUpdated);
    EXPECT_EQ(passed.reports[k].frame->inputs.status, InputStatus::kSound) << "samples around the start";
  }
  EXPECT_TRUE(navigator.health());
}

TEST(OnlineNavigator, JudgesTheCalibrationFromTheFirstFrameOfTheStartOn) {
  const Scene scene = scene_with(MotionModel::kImu);
  for (const Method method : {Method::kEkf, Method::kAdaptive}) {
    OnlineNavigator navigator(options_of(scene, method), scene.calibration, soon());
    (void)pass(navigator, scene);
    const auto known = navigator.calibration_report();
    ASSERT_TRUE(known);
    EXPECT_EQ(known->state.from_ns, scene.frames.front().t_ns) << to_string(method);
  }
}

TEST(OnlineNavigator, WithOdometryTheFirstFrameIsTheStartAndNotLost) {
  const Scene scene = scene_with(MotionModel::kOdometry);
  OnlineNavigator navigator(options_of(scene, Method::kLcekf), scene.calibration);
  const OnlineReport first = pass(navigator, scene, 0, 1).reports.front();
  EXPECT_EQ(first.start->status, StartStatus::kReady);
  ASSERT_TRUE(first.frame);
  EXPECT_GT(first.frame->initialized, 0U);
}

TEST(OnlineNavigator, HasNoStateBeforeTheStart) {
  const Scene scene = scene_with(MotionModel::kImu);
  OnlineNavigator navigator(options_of(scene, Method::kLcekf), scene.calibration);
  (void)pass(navigator, scene, 0, 3);
  EXPECT_FALSE(navigator.started());
  EXPECT_THROW((void)navigator.estimate(), std::logic_error);
  EXPECT_THROW((void)navigator.predict(kMs), std::logic_error);
  EXPECT_THROW((void)navigator.navigator(), std::logic_error);
  EXPECT_THROW(navigator.show_true_rig({0, scene.calibration.theta}), std::logic_error);
  EXPECT_FALSE(navigator.health());
  EXPECT_EQ(navigator.calibration_report(), nullptr);
  EXPECT_EQ(navigator.calibration().theta, scene.calibration.theta);
}

TEST(OnlineNavigator, OfAKnownStartIsTheNavigatorBitByBit) {
  const Scene scene = scene_with(MotionModel::kImu, 1.0);
  const NavigatorOptions options = options_of(scene, Method::kLcekf);
  OnlineNavigator navigator(options, scene.calibration);
  navigator.reset(scene.initial);
  ASSERT_TRUE(navigator.started());
  const Passed passed = pass(navigator, scene);
  Navigator alone(options, scene.calibration, scene.initial);
  Feed feed{scene};
  std::vector<Estimate> expected;
  for (const StereoFrame& frame : scene.frames) {
    feed.until(alone, frame.t_ns);
    alone.process(frame);
    expected.push_back(alone.estimate());
  }
  expect_same_bits(passed.estimates, expected);
  EXPECT_FALSE(passed.reports.front().start);
}

TEST(OnlineNavigator, ResetToAKnownStateGoesOnWithTheSamplesThatItHas) {
  const Scene scene = scene_with(MotionModel::kImu, 1.0);
  OnlineNavigator navigator(options_of(scene, Method::kEkf), scene.calibration);
  navigator.reset(scene.initial);
  Feed feed{scene};
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    feed.until(navigator, scene.frames[k].t_ns + 100 * kMs);  // samples come before their frames
    const OnlineReport report = navigator.process(scene.frames[k]);
    EXPECT_EQ(report.frame->inputs.status, InputStatus::kSound);
    if (k == 10) {
      InitialState known = scene.initial;
      known.nav = navigator.estimate().nav();
      navigator.reset(known);
      EXPECT_TRUE(navigator.estimate().landmarks().empty());
    }
  }
}

TEST(OnlineNavigator, ResetStartsFromTheSensorsAnewAndTimeBeginsAnewWithIt) {
  const Scene scene = scene_with(MotionModel::kImu);
  OnlineNavigator navigator(options_of(scene, Method::kLcekf), scene.calibration, soon());
  const Passed first = pass(navigator, scene);
  navigator.reset();
  EXPECT_FALSE(navigator.started());
  expect_same_bits(pass(navigator, scene).estimates, first.estimates);
  navigator.reset();
  (void)pass(navigator, scene, 0, 5);  // in the middle of a start
  navigator.reset();
  expect_same_bits(pass(navigator, scene).estimates, first.estimates);
}

TEST(OnlineNavigator, RefusesAStateThatDoesNotFitAndKeepsItsOwn) {
  const Scene scene = scene_with(MotionModel::kImu);
  OnlineNavigator navigator(options_of(scene, Method::kLcekf), scene.calibration, soon());
  (void)pass(navigator, scene);
  const NavigationState before = navigator.estimate().nav();
  InitialState wrong = scene.initial;
  wrong.nav.T_world_body.p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(navigator.reset(wrong), std::invalid_argument);
  EXPECT_EQ(navigator.estimate().nav().t_ns, before.t_ns);
  EXPECT_EQ(navigator.estimate().nav().T_world_body.p, before.T_world_body.p);
}

/// What must not be given at this point is refused, and leaves no trace.
void expect_refusals(OnlineNavigator& navigator, std::int64_t frame_ns, std::int64_t sample_ns) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(navigator.process({frame_ns, {}}), std::invalid_argument) << "twice";
  EXPECT_THROW(navigator.process({frame_ns - kMs, {}}), std::invalid_argument) << "older";
  EXPECT_THROW(navigator.process({frame_ns + 4000000 * kMs, {}}), std::invalid_argument) << "hours ahead";
  EXPECT_THROW(navigator.process({frame_ns + 50 * kMs, {{7, {1.0, 1.0}, {nan, 1.0}, true, true}}}),
               std::invalid_argument)
      << "not finite";
  EXPECT_THROW(navigator.add_imu({sample_ns, none, none}), std::invalid_argument) << "twice";
  EXPECT_THROW(navigator.add_imu({sample_ns - kMs, none, none}), std::invalid_argument) << "out of order";
  EXPECT_THROW(navigator.add_imu({sample_ns + kMs, {nan, 0.0, 0.0}, none}), std::invalid_argument);
  EXPECT_THROW(navigator.add_imu({sample_ns + 4000000 * kMs, none, none}), std::invalid_argument);
  EXPECT_THROW(navigator.add_odometry({sample_ns + kMs, none, none}), std::invalid_argument)
      << "not asked for";
}

TEST(OnlineNavigator, RefusesWhatIsOutOfOrderBeforeTheStartAsAfterAndNothingHasChanged) {
  const Scene scene = scene_with(MotionModel::kImu);
  const NavigatorOptions options = options_of(scene, Method::kLcekf);
  OnlineNavigator navigator(options, scene.calibration, soon());
  Feed feed{scene};
  std::vector<Estimate> estimates;
  for (const StereoFrame& frame : scene.frames) {
    feed.until(navigator, frame.t_ns);
    (void)navigator.process(frame);
    if (navigator.started()) {
      estimates.push_back(navigator.estimate());
    }
    expect_refusals(navigator, frame.t_ns, scene.inputs[feed.next - 1].t_ns);
  }
  expect_same_bits(estimates, by_hand(scene, options));
}

TEST(OnlineNavigator, CountsSamplesThatComeTooLateForTheirFrame) {
  const Scene scene = scene_with(MotionModel::kImu);
  OnlineNavigator navigator(options_of(scene, Method::kLcekf), scene.calibration, soon());
  std::size_t late = 0;
  Feed feed{scene};
  for (const StereoFrame& frame : scene.frames) {
    feed.until(navigator, frame.t_ns - 20 * kMs);
    const OnlineReport report = navigator.process(frame);
    late += report.frame ? report.frame->inputs.faults[InputFault::kLate] : 0;
  }
  ASSERT_TRUE(navigator.started()) << "a gap is not the end of a start";
  EXPECT_GT(late, 3U * 15U);
}

TEST(OnlineNavigator, WaitsForInputsAndTheirClockBeforeItTakesTheFirstFrame) {
  const Scene scene = scene_with(MotionModel::kImu);
  const NavigatorOptions options = options_of(scene, Method::kLcekf);
  OnlineNavigator navigator(options, scene.calibration, soon());
  const auto expect_waiting = [&](std::int64_t t_ns) {
    const OnlineReport report = navigator.process({t_ns, {}});
    EXPECT_EQ(report.start->status, StartStatus::kWaiting);
    EXPECT_THAT(report.start->missing, HasSubstr("IMU samples"));
  };
  expect_waiting(-500 * kMs);
  navigator.add_imu({-100 * kMs, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
  expect_waiting(-200 * kMs);
  expect_waiting(10000 * kMs);  // of another clock
  const Passed passed = pass(navigator, scene);
  EXPECT_FALSE(passed.estimates.empty());
}

TEST(OnlineNavigator, SaysAtOnceThatOptionsContradictEachOther) {
  const Scene scene = scene_with(MotionModel::kImu, 0.5);
  NavigatorOptions options = options_of(scene, Method::kLcekf);
  options.gate_probability = 2.0;
  EXPECT_THAT(message_of<std::invalid_argument>([&] { OnlineNavigator(options, scene.calibration); }),
              HasSubstr("gate_probability"));
}

}  // namespace
}  // namespace limber
