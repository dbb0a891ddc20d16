// SPDX-License-Identifier: MIT
#include "limber/decalibrate/bend_tracks.hpp"

#include <gtest/gtest.h>

#include <map>

#include "limber/datasets/interpolate.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"

namespace limber {
namespace {

Scenario exact_drone() {
  Scenario scenario;
  scenario.duration = 1.0;
  scenario.noise.pixel = 0.0;
  scenario.noise.stated = false;
  scenario.rig.cam1.distortion = RadialTangential{-0.2, 0.03, 1e-4, -2e-4};
  return scenario;
}

DecalibrationSignal step() {
  DecalibrationSignal signal;
  signal.amplitude << 0.02, -0.03, 0.01, 0.3, -0.05, 0.02;
  signal.shape = StepsShape{{{0.5, 1.0}}};
  return signal;
}

/// Largest distance of right pixels that both recordings have [px], and how many there are.
std::pair<double, int> difference(const Recording& a, const Recording& b) {
  double largest = 0.0;
  int count = 0;
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    std::map<std::int64_t, Eigen::Vector2d> pixels;
    for (const StereoObservation& point : a.frames[k].observations) {
      if (point.in_cam1) pixels[point.track_id] = point.uv_cam1;
    }
    for (const StereoObservation& point : b.frames[k].observations) {
      if (!point.in_cam1 || !pixels.contains(point.track_id)) continue;
      largest = std::max(largest, (pixels[point.track_id] - point.uv_cam1).norm());
      ++count;
    }
  }
  return {largest, count};
}

class BendTracksBy : public ::testing::TestWithParam<bool> {};  // whether the truth is known

TEST_P(BendTracksBy, GivesWhatABendingRigWouldHaveSeen) {
  Scenario bending = exact_drone();
  bending.decalibration = {step()};
  const Recording expected = simulate(bending, 3);
  Recording sound = simulate(exact_drone(), 3);
  if (!GetParam()) {
    sound.truth.landmarks.clear();
    sound.truth.rig.clear();
  }
  const TrackBending bent = bend_tracks(sound, BentRig(sound, {step()}, 0, BentRig::Parts::kAll));
  const auto [largest, count] = difference(expected, bent.recording);
  EXPECT_LT(largest, 1e-6);
  EXPECT_GT(count, 500);
  EXPECT_GT(difference(sound, bent.recording).first, 5.0);
  EXPECT_EQ(bent.without_depth, 0u);
  for (const TrueRig& truth : expected.truth.rig) {
    EXPECT_TRUE(true_rig_at(bent.recording.truth.rig, truth.t_ns).theta.isApprox(truth.theta, 1e-12));
  }
  EXPECT_EQ(bent.recording.calibration.theta, sound.calibration.theta);  // as given
}
INSTANTIATE_TEST_SUITE_P(TruthKnown, BendTracksBy, ::testing::Bool());

TEST(BendTracks, ComesBackByTheInverseProfile) {
  const Recording sound = simulate(exact_drone(), 4);
  const Recording bent = bend_tracks(sound, BentRig(sound, {step()}, 0, BentRig::Parts::kAll)).recording;
  DecalibrationSignal back = step();
  back.amplitude *= -1.0;
  const Recording again = bend_tracks(bent, BentRig(bent, {back}, 0, BentRig::Parts::kAll)).recording;
  const auto [largest, count] = difference(sound, again);
  EXPECT_LT(largest, 1e-6);
  EXPECT_GT(count, 500);
  EXPECT_TRUE(again.truth.rig.back().theta.isApprox(sound.calibration.theta, 1e-12));
}

TEST(BendTracks, LeavesOutRightPixelsWhoseDepthNobodyKnows) {
  Recording sound = simulate(exact_drone(), 5);
  sound.truth.landmarks.clear();
  ASSERT_TRUE(sound.frames.back().observations.front().in_cam1);
  sound.frames.back().observations.front().in_cam0 = false;
  const TrackBending moved = bend_tracks(sound, BentRig(sound, {step()}, 0, BentRig::Parts::kAll));
  EXPECT_EQ(moved.without_depth, 1u);
  EXPECT_EQ(moved.recording.frames.back().observations.size(), sound.frames.back().observations.size() - 1);
}

TEST(DecalibrationFromString, ReadsAmplitudesInTheirUnits) {
  const DecalibrationSignal signal =
      decalibration_from_string("ay=0.5,tx=5%,shape=vibration,frequency=2", 0.2);
  RigParameters expected = RigParameters::Zero();
  expected[1] = 0.5 * detail::kDegree;
  expected[3] = 0.01;
  EXPECT_TRUE(signal.amplitude.isApprox(expected, 1e-12));
  EXPECT_NEAR(std::get<SinusShape>(signal.shape).angular_frequency, 12.566370614, 1e-6);
  EXPECT_TRUE(std::holds_alternative<ConstantShape>(decalibration_from_string("az=1", 0.2).shape));
}

TEST(DecalibrationFromString, RefusesWhatItCannotRead) {
  for (const char* text :
       {"ay", "ay=", "=1", "ay=fast", "shape=wobble,ay=1", "ay=1,frequency=2", "ay=1,,az=1"}) {
    EXPECT_THROW((void)decalibration_from_string(text, 0.2), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace limber
