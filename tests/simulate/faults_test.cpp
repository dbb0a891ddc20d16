// SPDX-License-Identifier: MIT
// Faults of sensors: at the stated times and nowhere else; the truth stays.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "message_of.hpp"
#include "shipped_scenario.hpp"
#include "simulate/recordings.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::same;

constexpr std::int64_t kOneSecond = 1'000'000'000;
constexpr double kStandardGravity = 9.80665;

Scenario sound_drone() {
  Scenario s = testing::shipped("drone_none", 4.0);
  return s;
}

/// A recording with a fault beside the same without.
struct Pair {
  Recording sound, faulty;

  explicit Pair(const std::string& fault) : sound(simulate(sound_drone(), 1)) {
    Scenario s = sound_drone();
    s.faults = {fault_from_string(fault)};
    faulty = simulate(s, 1);
    EXPECT_EQ(sound.truth.motion.states.size(), faulty.truth.motion.states.size());
    for (std::size_t k = 0; k < sound.truth.motion.states.size(); ++k) {
      EXPECT_EQ(sound.truth.motion.states[k].p_world_body, faulty.truth.motion.states[k].p_world_body);
      EXPECT_EQ(sound.truth.motion.states[k].R_world_body, faulty.truth.motion.states[k].R_world_body);
    }
  }
};

/// Whether `t_ns` lies in [begin, end) seconds.
bool in(double begin, double end, std::int64_t t_ns) {
  const double t = static_cast<double>(t_ns) / 1e9;
  return t >= begin && t < end;
}

TEST(ImuFaults, AGapLeavesOutTheSamplesOfItsTime) {
  const Pair p("imu-gap=1:0.5");
  std::size_t k = 0;
  for (const ImuSample& sample : p.sound.imu) {
    if (!in(1.0, 1.5, sample.t_ns)) {
      ASSERT_TRUE(same(sample, p.faulty.imu.at(k++)));
    }
  }
  EXPECT_EQ(k, p.faulty.imu.size());
  EXPECT_EQ(p.sound.imu.size() - k, 100u);
  EXPECT_TRUE(same(p.sound.frames, p.faulty.frames));
}

TEST(ImuFaults, AStuckSampleRepeatsTheLastOneBefore) {
  const Pair p("imu-stuck=1:0.5");
  ASSERT_EQ(p.sound.imu.size(), p.faulty.imu.size());
  for (std::size_t k = 0; k < p.sound.imu.size(); ++k) {
    ImuSample expected = in(1.0, 1.5, p.sound.imu[k].t_ns) ? p.sound.imu[199] : p.sound.imu[k];
    expected.t_ns = p.sound.imu[k].t_ns;
    ASSERT_TRUE(same(expected, p.faulty.imu[k]));
  }
}

TEST(ImuFaults, SaturationClipsEachComponent) {
  const Pair p("imu-saturation=1:20");
  const double gyro = 20.0 * detail::kDegree;
  std::size_t clipped = 0;
  for (std::size_t k = 0; k < p.sound.imu.size(); ++k) {
    const Vector3d accel = p.sound.imu[k].accel_imu.cwiseMax(-kStandardGravity).cwiseMin(kStandardGravity);
    const Vector3d omega = p.sound.imu[k].omega_imu.cwiseMax(-gyro).cwiseMin(gyro);
    ASSERT_LT((accel - p.faulty.imu[k].accel_imu).norm(), 1e-12);
    ASSERT_LT((omega - p.faulty.imu[k].omega_imu).norm(), 1e-12);
    clipped += same(p.sound.imu[k], p.faulty.imu[k]) ? 0 : 1;
  }
  EXPECT_GT(clipped, 100u);
}

TEST(ImuFaults, ASpikeHitsOneSampleOfTheAccelerometer) {
  const Pair p("imu-spike=1.002:10");
  for (std::size_t k = 0; k < p.sound.imu.size(); ++k) {
    const Vector3d added = p.faulty.imu[k].accel_imu - p.sound.imu[k].accel_imu;
    ASSERT_NEAR(added.norm(), k == 201 ? 10.0 * kStandardGravity : 0.0, 1e-9);
    ASSERT_EQ(p.faulty.imu[k].omega_imu, p.sound.imu[k].omega_imu);
  }
}

TEST(ImuFaults, BiasStepsAreInTheSamplesAndInTheTrueBiases) {
  const Pair gyro("gyro-bias-step=1:0.05"), accel("accel-bias-step=1:0.2");
  for (std::size_t k = 0; k < gyro.sound.imu.size(); ++k) {
    const bool later = gyro.sound.imu[k].t_ns >= kOneSecond;
    const Vector3d turn = gyro.faulty.imu[k].omega_imu - gyro.sound.imu[k].omega_imu;
    ASSERT_NEAR(turn.norm(), later ? 0.05 : 0.0, 1e-9);
    ASSERT_LT(
        (turn - (gyro.faulty.truth.motion.states[k].bias_gyro - gyro.sound.truth.motion.states[k].bias_gyro))
            .norm(),
        1e-9);
    ASSERT_EQ(gyro.faulty.imu[k].accel_imu, gyro.sound.imu[k].accel_imu);
    ASSERT_NEAR((accel.faulty.imu[k].accel_imu - accel.sound.imu[k].accel_imu).norm(), later ? 0.2 : 0.0,
                1e-9);
  }
}

TEST(ImuFaults, AClockStepMovesTheStampsOfWhatComesLater) {
  const Pair late("clock-step=1:0.1");
  ASSERT_EQ(late.sound.imu.size(), late.faulty.imu.size());
  for (std::size_t k = 0; k < late.sound.imu.size(); ++k) {
    const std::int64_t t_ns = late.sound.imu[k].t_ns;
    ASSERT_EQ(late.faulty.imu[k].t_ns, t_ns + (t_ns >= kOneSecond ? kOneSecond / 10 : 0));
    ASSERT_EQ(late.faulty.imu[k].accel_imu, late.sound.imu[k].accel_imu);
  }
  const Pair early("clock-step=1:-0.1");
  // Sample 200 is stamped 0.9 s; the first later than 0.995 s is sample 220 with 1.0 s.
  ASSERT_EQ(early.faulty.imu.size(), early.sound.imu.size() - 20);
  EXPECT_EQ(early.faulty.imu[200].t_ns, kOneSecond);
  EXPECT_EQ(early.faulty.imu[200].accel_imu, early.sound.imu[220].accel_imu);
  for (std::size_t k = 1; k < early.faulty.imu.size(); ++k) {
    ASSERT_GT(early.faulty.imu[k].t_ns, early.faulty.imu[k - 1].t_ns);
  }
}

TEST(ImuFaults, ActInTheOrderOfTheSensorWhateverTheOrderOfTheList) {
  Scenario s = sound_drone();
  s.faults = {fault_from_string("imu-saturation=2:1000"), fault_from_string("imu-spike=1:100")};
  for (const ImuSample& sample : simulate(s, 1).imu) {
    ASSERT_LE(sample.accel_imu.cwiseAbs().maxCoeff(), 2.0 * kStandardGravity + 1e-9);
  }
}

TEST(CameraFaults, AGapLeavesOutTheFramesOfItsTime) {
  const Pair p("frame-gap=1:0.5");
  std::size_t k = 0;
  for (const StereoFrame& frame : p.sound.frames) {
    if (!in(1.0, 1.5, frame.t_ns)) {
      ASSERT_TRUE(same(frame, p.faulty.frames.at(k++)));
    }
  }
  EXPECT_EQ(k, p.faulty.frames.size());
  EXPECT_EQ(p.sound.frames.size() - k, 10u);
  EXPECT_TRUE(same(p.sound.imu, p.faulty.imu));
}

TEST(CameraFaults, RepeatedFramesShowTheLastOneBefore) {
  const Pair p("frames-repeated=1:0.1");
  for (std::size_t k = 0; k < p.sound.frames.size(); ++k) {
    StereoFrame expected = k == 20 || k == 21 ? p.sound.frames[19] : p.sound.frames[k];
    expected.t_ns = p.sound.frames[k].t_ns;
    ASSERT_TRUE(same(expected, p.faulty.frames.at(k)));
  }
}

TEST(CameraFaults, ALateRightImageShowsWhereThePointsWere) {
  Scenario s = sound_drone();
  s.noise.pixel = 0.0;
  const Recording sound = simulate(s, 1);
  s.faults = {fault_from_string("right-late=1:2:0.1")};  // two frames
  const Recording faulty = simulate(s, 1);
  std::size_t compared = 0;
  for (std::size_t k = 0; k < sound.frames.size(); ++k) {
    const bool late = in(1.0, 3.0, sound.frames[k].t_ns);
    std::map<std::int64_t, StereoObservation> left, right;
    for (const StereoObservation& o : sound.frames[k].observations) {
      left[o.track_id] = o;
    }
    for (const StereoObservation& o : sound.frames[late ? k - 2 : k].observations) {
      right[o.track_id] = o;
    }
    for (const StereoObservation& o : faulty.frames.at(k).observations) {
      if (left.contains(o.track_id) && right.contains(o.track_id)) {
        ASSERT_EQ(o.uv_cam0, left[o.track_id].uv_cam0);
        ASSERT_EQ(o.uv_cam1, right[o.track_id].uv_cam1);
        compared += late ? 1 : 0;
      }
    }
  }
  EXPECT_GT(compared, 500u);
}

// ---- in files and in short

TEST(FaultText, SaysTheSameAsAFile) {
  const Scenario s = parse_scenario(
      "faults:\n"
      "  - {kind: imu_gap, at: 5, duration: 2}\n"
      "  - {kind: imu_spike, at: 3, size: 100}\n"
      "  - {kind: imu_saturation, accel: 2, gyro: 250}\n"
      "  - {kind: right_late, at: 1, duration: 4, delay: 0.05}\n"
      "  - {kind: clock_step, at: 7, size: -0.1}\n",
      "case.yaml");
  Scenario in_short;
  for (const char* text : {"imu-gap=5:2", "imu-spike=3:100", "imu-saturation=2:250", "right-late=1:4:0.05",
                           "clock-step=7:-0.1"}) {
    in_short.faults.push_back(fault_from_string(text));
  }
  in_short.name = s.name;
  EXPECT_EQ(format_scenario(s), format_scenario(in_short));
  EXPECT_EQ(format_scenario(parse_scenario(format_scenario(s), "case.yaml")), format_scenario(s));
}

TEST(FaultText, SaysWhatIsWrong) {
  for (const char* text : {"imu-gap", "imu-gap=5", "imu-gap=5:2:1", "imu-hole=5:2", ""}) {
    const std::string message = testing::message_of([&] { (void)fault_from_string(text); });
    EXPECT_NE(message.find("imu-gap=at:duration"), std::string::npos) << message;
  }
  EXPECT_EQ(testing::message_of([] { (void)fault_from_string("imu-gap=5:0"); }),
            "fault 'imu-gap=5:0': expected duration as a number in (0, 1000000] s, found '0'");
}

}  // namespace
}  // namespace limber
