// SPDX-License-Identifier: MIT
// One seed gives one answer, and switching one thing off leaves the rest as it is.
#include "limber/simulate/simulator.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/errors.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/measure/rig.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "real_data.hpp"
#include "simulate/recordings.hpp"
#include "simulate/scenarios.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using Eigen::Vector4d;
using testing::brief;
using testing::observation_count;
using testing::same;
using testing::shipped;

// ---- one seed, one answer

TEST(Simulate, GivesTheSameBitsForTheSameSeedAndRun) {
  for (const char* name : {"paper_iv", "drone_square", "walk"}) {
    const Scenario s = shipped(name);
    const Recording a = simulate(s, 3, 5), b = simulate(s, 3, 5);
    EXPECT_TRUE(same(a.imu, b.imu)) << name;
    EXPECT_TRUE(same(a.odometry, b.odometry)) << name;
    EXPECT_TRUE(same(a.frames, b.frames)) << name;
    EXPECT_TRUE(same(a.truth.motion.states, b.truth.motion.states)) << name;
    EXPECT_TRUE(same(a.truth.rig, b.truth.rig)) << name;
    EXPECT_EQ(a.truth.landmarks, b.truth.landmarks) << name;
  }
}

TEST(Simulate, GivesOtherDrawsForAnotherSeedOrRun) {
  const Recording a = simulate(brief(), 1, 0);
  for (const Recording& b : {simulate(brief(), 2, 0), simulate(brief(), 1, 1)}) {
    EXPECT_NE(a.imu[7].omega_imu, b.imu[7].omega_imu);
    EXPECT_NE(a.truth.motion.states[7].p_world_body, b.truth.motion.states[7].p_world_body);
    EXPECT_NE(a.truth.motion.states[7].bias_gyro, b.truth.motion.states[7].bias_gyro);
    EXPECT_NE(a.truth.landmarks, b.truth.landmarks);
  }
}

TEST(Simulate, KeepsTrajectoryAndWorldInAllRunsWhenAskedTo) {
  Scenario s = brief();
  s.same_world_in_all_runs = true;
  const Recording a = simulate(s, 1, 0), b = simulate(s, 1, 1);
  EXPECT_EQ(a.truth.motion.states.back().p_world_body, b.truth.motion.states.back().p_world_body);
  EXPECT_EQ(a.truth.landmarks.begin()->second, b.truth.landmarks.begin()->second);
  EXPECT_NE(a.imu[7].omega_imu, b.imu[7].omega_imu);
  EXPECT_NE(a.frames[0].observations[0].uv_cam0, b.frames[0].observations[0].uv_cam0);
}

// ---- switching one thing off leaves the rest as it is

/// Pixel noise by (frame, track).
std::map<std::pair<std::int64_t, std::int64_t>, Vector4d> pixel_noise(const Recording& recording) {
  std::map<std::pair<std::int64_t, std::int64_t>, Vector4d> noise;
  testing::visit_residuals(recording,
                           [&](const StereoFrame& frame, const StereoObservation& o, const Vector4d& r) {
                             noise[{frame.t_ns, o.track_id}] = r;
                           });
  return noise;
}

TEST(RandomStreams, AreNotMovedByADecalibration) {
  const Recording exact = simulate(shipped("paper_i"), 1), bent = simulate(shipped("paper_v_strong"), 1);
  EXPECT_TRUE(same(exact.truth.motion.states, bent.truth.motion.states));
  EXPECT_TRUE(same(exact.imu, bent.imu));
  const auto noise_exact = pixel_noise(exact), noise_bent = pixel_noise(bent);
  std::size_t common = 0;
  for (const auto& [key, noise] : noise_bent) {
    if (const auto it = noise_exact.find(key); it != noise_exact.end()) {
      ASSERT_LT((it->second - noise).norm(), 1e-9);
      ++common;
    }
  }
  EXPECT_GT(common, noise_exact.size() * 9 / 10);
  EXPECT_NE(observation_count(exact), observation_count(bent));  // points at the edge come and go
}

TEST(RandomStreams, AreNotMovedByLeavingOutTheImu) {
  Scenario s = brief();
  const Recording with = simulate(s, 1);
  s.use_imu = false;
  const Recording without = simulate(s, 1);
  EXPECT_TRUE(same(with.frames, without.frames));
  EXPECT_EQ(with.truth.motion.states.back().R_world_body, without.truth.motion.states.back().R_world_body);
}

TEST(RandomStreams, AreNotMovedByAnOdometerOrByPixelNoise) {
  Scenario s = brief();
  const Recording plain = simulate(s, 1);
  s.odometry = OdometryScenario{};
  s.noise.pixel = 2.0;
  const Recording other = simulate(s, 1);
  EXPECT_TRUE(same(plain.imu, other.imu));
  EXPECT_TRUE(same(plain.truth.motion.states, other.truth.motion.states));
  EXPECT_EQ(plain.truth.landmarks, other.truth.landmarks);
  const auto noise_plain = pixel_noise(plain);
  for (const auto& [key, noise] : pixel_noise(other)) {
    ASSERT_LT((noise - 4.0 * noise_plain.at(key)).norm(), 1e-9);
  }
}

TEST(RandomStreams, AreNotMovedByDropouts) {
  Scenario s = brief();
  const Recording whole = simulate(s, 1);
  s.dropout = {.right_detections = 0.3, .frames = 0.2, .imu_samples = 0.1};
  const Recording part = simulate(s, 1);
  std::size_t k = 0;
  for (const ImuSample& sample : part.imu) {
    while (whole.imu.at(k).t_ns < sample.t_ns) {
      ++k;
    }
    ASSERT_TRUE(same(whole.imu[k], sample));
  }
  const auto noise_whole = pixel_noise(whole);
  for (const auto& [key, noise] : pixel_noise(part)) {
    ASSERT_EQ(noise.head<2>(), noise_whole.at(key).head<2>());
    ASSERT_TRUE(std::isnan(noise[2]) || noise.tail<2>() == noise_whole.at(key).tail<2>());
  }
}

}  // namespace
}  // namespace limber
