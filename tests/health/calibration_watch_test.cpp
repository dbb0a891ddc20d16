// SPDX-License-Identifier: MIT
#include "limber/health/calibration_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <stdexcept>

#include "health/stereo_world.hpp"
#include "limber/core/time.hpp"
#include "sanitized.hpp"

namespace limber {
namespace {

using enum HealthVerdict;
using testing::fly_past;
using testing::World;
using testing::WorldOptions;

constexpr double kDegree = std::numbers::pi / 180.0;

struct Judged {
  std::shared_ptr<const CalibrationReport> last;
  std::vector<CalibrationState> past;
  std::int64_t begin_ns = 0;
};

Judged judge_world(const WorldOptions& options, const WatchOptions& how = {}) {
  const World world = fly_past(options);
  CalibrationWatch watch(how, world.assumed, true);
  Judged out;
  out.begin_ns = world.frames.front().t_ns;
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    watch.add(world.frames[k], world.poses[k], {});
    if (watch.report() && watch.report() != out.last) {
      const std::vector<CalibrationState>& past = watch.report()->past;
      out.past.insert(out.past.end(), past.begin(), past.end());
    }
    out.last = watch.report();
  }
  return out;
}

WorldOptions with_step(double at, double degrees, double back = 1e9) {
  WorldOptions options;
  options.seconds = 20.0;
  options.points = 40;
  options.error = [=](double t) {
    return t < at || t > back ? RigParameters(RigParameters::Zero())
                              : RigParameters(degrees * kDegree * RigParameters::Unit(0));
  };
  return options;
}

TEST(CalibrationWatch, ASoundRigIsOkAndDoesNotChange) {
  const Judged judged = judge_world(with_step(0.0, 0.0));
  EXPECT_EQ(judged.last->state.verdict, kOk) << judged.last->state.effect.depth.high;
  EXPECT_TRUE(judged.past.empty());
  EXPECT_GT(judged.last->state.windows, 5u);
}

TEST(CalibrationWatch, FollowsTheStateAndSaysSinceWhen) {
  const Judged judged = judge_world(with_step(9.0, 0.4));
  ASSERT_EQ(judged.past.size(), 1u);
  EXPECT_EQ(judged.past.front().verdict, kOk);
  EXPECT_EQ(judged.last->state.verdict, kDecalibrated);
  EXPECT_EQ(judged.last->state.named, 0u);
  EXPECT_NEAR(seconds_between(judged.begin_ns, judged.last->state.from_ns), 9.0, 2.6);
}

TEST(CalibrationWatch, AnErrorThatIsOverIsOver) {
  const Judged judged = judge_world(with_step(5.0, 0.4, 12.0));
  EXPECT_EQ(judged.last->state.verdict, kOk);
  EXPECT_EQ(judged.past.size(), 2u);
}

TEST(CalibrationWatch, AShortErrorOfDepthIsOver) {
  if (testing::kSanitized) {
    GTEST_SKIP() << "a long statistic of what the other tests run, too";
  }
  // Its end is known by three windows on either side. None of the first 60 seeds misses it; with degrees of
  // freedom by the number of windows alone, as if clusters said nothing, half of them do.
  int missed = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    WorldOptions options;
    options.seconds = 30.0;
    options.points = 40;
    options.per_track_px = 0.3;
    options.seed = seed;
    options.error = [](double t) {
      return RigParameters((t < 9.0 || t > 18.0 ? 0.0 : 0.12) * kDegree * RigParameters::Unit(1));
    };
    const Judged judged = judge_world(options);
    if (judged.past.size() != 2u) {
      ++missed;
      continue;
    }
    EXPECT_EQ(judged.last->state.verdict, kOk) << judged.last->state.effect.depth.high;
    EXPECT_EQ(judged.past[0].verdict, kOk);
    EXPECT_EQ(judged.past[1].verdict, kDecalibrated);
    EXPECT_EQ(judged.past[1].named, 1u);
    EXPECT_NEAR(seconds_between(judged.begin_ns, judged.last->state.from_ns), 18.0, 2.6);
  }
  EXPECT_LE(missed, 1);
}

/// Nod that grows from 0 to so many degrees over the whole recording.
WorldOptions with_ramp(double degrees, unsigned seed) {
  WorldOptions options;
  options.seconds = 30.0;
  options.points = 40;
  options.per_track_px = 0.3;
  options.per_cell_px = 0.1;
  options.seed = seed;
  options.error = [=](double t) {
    return RigParameters(t / options.seconds * degrees * kDegree * RigParameters::Unit(0));
  };
  return options;
}

TEST(CalibrationWatch, JudgesADriftAtItsEndAndGivesItsRate) {
  if (testing::kSanitized) {
    GTEST_SKIP() << "a long statistic of what the other tests run, too";
  }
  int held = 0, drifts = 0, right_axis = 0;
  constexpr int kSeeds = 20;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const CalibrationState state = judge_world(with_ramp(0.08, seed)).last->state;
    if (!state.drift) {
      continue;
    }
    ++drifts;
    // So small a nod looks like a vertical shift now and then: 3 of 110 drifts of 120 seeds are named so.
    right_axis += state.drift->named == 0u ? 1 : 0;
    EXPECT_NE(state.verdict, kOk);  // 0.6 px at the end
    const double rate = state.drift->change.delta(0) / state.drift->seconds;
    const double sigma = state.drift->change.sigma()(0) / state.drift->seconds;
    held += std::abs(rate - 0.08 * kDegree / 30.0) < 1.96 * sigma ? 1 : 0;
  }
  EXPECT_GE(drifts, 18);
  EXPECT_GE(right_axis, drifts - 2);
  EXPECT_GE(held, drifts - 3);
}

TEST(CalibrationWatch, ReckonsWithADriftThatItCannotSee) {
  if (testing::kSanitized) {
    GTEST_SKIP() << "a long statistic of what the other tests run, too";
  }
  int held = 0;
  constexpr int kSeeds = 20;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const CalibrationState state = judge_world(with_ramp(0.02, seed)).last->state;
    EXPECT_NE(state.verdict, kDegraded);
    const double sigma = state.estimate.sigma()(0);
    held += std::abs(state.estimate.delta(0) - 0.02 * kDegree) < 1.96 * sigma ? 1 : 0;
    EXPECT_LT(sigma, 0.02 * kDegree);
  }
  EXPECT_GE(held, kSeeds - 3);
}

TEST(CalibrationWatch, ASoundRigDoesNotDrift) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const CalibrationState state = judge_world(with_ramp(0.0, seed)).last->state;
    EXPECT_FALSE(state.drift);
    EXPECT_NE(state.verdict, kDegraded);
  }
}

/// Windows that see a nod of so many plausible errors each, to a hundredth of one.
std::vector<RigEvidence> windows_off(const std::vector<double>& nods) {
  std::vector<RigEvidence> out;
  for (const double nod : nods) {
    RigEvidence& window = out.emplace_back();
    window.from_ns = static_cast<std::int64_t>(out.size()) * 2'500'000'000;
    window.to_ns = window.from_ns + 2'500'000'000;
    window.all.information = 1e4 * NormalEquations::Matrix::Identity();
    window.all.vector = 1e4 * nod * NormalEquations::Vector::Unit(0);
    window.products.tracks = window.products.both = window.products.of_a_pixel[0] = window.all.information;
    window.errors.squares[0] = window.errors.weights[0] = 1.0;
    window.epipolar = NormalEquations::Matrix::Zero();
    window.epipolar(0, 0) = 64.0;  // px a plausible error, squared
    window.points = 1;
  }
  return out;
}

/// Looked at after each window, a p-value wavers about any limit.
TEST(CalibrationWatch, ADriftThatWasSaidIsSaidWhileItIsReckonedWith) {
  const RigParameters theta = testing::world_calibration().theta;
  const auto drifts = [&](double noise, bool before) {
    std::vector<double> nods;
    for (const int sign : {1, -1, -1, 1, 1, -1, 1, -1, -1, 1}) {
      nods.push_back(0.05 * static_cast<double>(nods.size()) + noise * sign);
    }
    return state_of(windows_off(nods), theta, true, {}, 0, before).drift.has_value();
  };
  double noise = 0.0;
  while (noise < 5.0 && drifts(noise, false)) {
    noise += 0.002;
  }
  EXPECT_GT(noise, 0.0);
  EXPECT_FALSE(drifts(noise, false));
  EXPECT_TRUE(drifts(noise, true));
  EXPECT_FALSE(drifts(10.0 * noise, true));
}

/// The first windows of a state that begins by chance differ, and those after them are back again.
TEST(CalibrationWatch, TheWayBackFromWindowsThatWereChosenIsNoDrift) {
  const RigParameters theta = testing::world_calibration().theta;
  const std::vector<RigEvidence> windows = windows_off({0.4, 0.4, 0.2, 0.0, 0.0, 0.0, 0.0});
  WatchOptions options;
  options.false_alarms_per_hour = 20.0;
  EXPECT_TRUE(state_of(windows, theta, true, options).drift);
  EXPECT_FALSE(state_of(windows, theta, true, options, 2).drift);
}

TEST(CalibrationWatch, StandingStillItCannotTell) {
  WorldOptions options = with_step(0.0, 0.0);
  options.speed = 0.0;
  const Judged judged = judge_world(options);
  EXPECT_EQ(judged.last->state.verdict, kCannotTell);
  EXPECT_EQ(judged.last->state.by_depth, kCannotTell);
}

/// On a recording of stars a handful of near tracks called the rig decalibrated by their depths.
TEST(CalibrationWatch, AFewTracksWithADepthJudgeNoDepths) {
  const WorldOptions options = with_step(0.0, 0.0);
  const World world = fly_past(options);
  const Judged judged = judge_world(options);
  BetaEstimate off = judged.last->state.whole;
  off.beta(1) += 20.0;                       // of 0.1 deg
  off.beta(NormalEquations::kLens) -= 20.0;  // and the lines know nothing of it
  CalibrationState state;
  state.tracks = 100;
  state.deep_tracks = kFewestTracks;
  judge_estimate(off, world.assumed.theta, true, {}, state);
  EXPECT_EQ(state.by_depth, kDecalibrated);
  EXPECT_EQ(state.verdict, kDecalibrated);
  state = {};
  state.tracks = 100;
  state.deep_tracks = kFewestTracks - 1;
  judge_estimate(off, world.assumed.theta, true, {}, state);
  EXPECT_EQ(state.by_depth, kCannotTell);
  EXPECT_EQ(state.verdict, state.by_epipolar == kOk ? kCannotTell : state.by_epipolar);
}

/// A window's regression is spread over the frames after it: 1 + 4 (1 + 3) + 2 slices at most, and a verdict.
TEST(CalibrationWatch, WhatAWindowSaysIsDoneInSlices) {
  const World world = fly_past(with_step(8.0, 0.5));
  CalibrationWatch watch({}, world.assumed, true);
  std::shared_ptr<const CalibrationReport> at_once;
  std::size_t waited = 0, longest = 0, ended = 0;
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    watch.add(world.frames[k], world.poses[k], {});
    const auto known = watch.report_at_once();
    if (watch.report() == known) {
      waited = 0;
      continue;
    }
    ++waited;
    longest = std::max(longest, waited);
    if (waited > 1) {
      ASSERT_TRUE(at_once);
      EXPECT_EQ(known->window.to_ns, at_once->window.to_ns);
      EXPECT_EQ(known->state.whole.beta, at_once->state.whole.beta);
    } else {
      ++ended;
    }
    at_once = known;
    if (watch.report()) {
      EXPECT_LT(watch.report()->window.to_ns, known->window.to_ns);
    }
  }
  EXPECT_GT(ended, 5U);
  EXPECT_GT(longest, 5U);
  EXPECT_LE(longest, 20U);
}

TEST(CalibrationWatch, AskedAtEveryFrameLooksAtEachWindowOnceAndSaysTheSame) {
  const World world = fly_past(with_step(8.0, 0.5));
  CalibrationWatch asked({}, world.assumed, true), left_alone({}, world.assumed, true);
  std::set<std::shared_ptr<const CalibrationReport>> early, late;
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    asked.add(world.frames[k], world.poses[k], {});
    left_alone.add(world.frames[k], world.poses[k], {});
    const auto known = asked.report_at_once();
    EXPECT_EQ(asked.report_at_once(), known) << "nothing is new";
    early.insert(known);
    late.insert(left_alone.report());
    ASSERT_EQ(asked.report() == nullptr, left_alone.report() == nullptr);
    if (asked.report()) {
      EXPECT_TRUE(early.contains(asked.report())) << "was known before";
      EXPECT_EQ(asked.report()->window.to_ns, left_alone.report()->window.to_ns);
      EXPECT_EQ(asked.report()->state.whole.beta, left_alone.report()->state.whole.beta);
      EXPECT_EQ(asked.report()->past.size(), left_alone.report()->past.size());
    }
  }
  EXPECT_GT(late.size(), 5U);
  EXPECT_LE(early.size(), late.size() + 1) << "the last window's slices may be left";
}

/// Where the trajectory is 5 % too long, the baseline that it was taken from is that much shorter.
TEST(CalibrationWatch, WhatATrustedLengthIsShowsBesideTheScaleOfTheTrajectory) {
  const World world = fly_past(with_step(0.0, 0.0));
  const RigParameters& theta = world.assumed.theta;
  const CalibrationState sound = judge_world(with_step(0.0, 0.0)).last->state;
  const auto along = [&](const CalibrationState& state) {
    return -theta.tail<3>().normalized().dot(state.estimate.delta.tail<3>()) / theta.tail<3>().norm();
  };
  const CalibrationState same = with_scale(sound, {0.0, kLeastScale}, theta, {});
  EXPECT_EQ(same.verdict, kOk);
  EXPECT_TRUE(same.estimate.covariance.isApprox(sound.estimate.covariance));
  const CalibrationState off = with_scale(sound, {0.05, kLeastScale}, theta, {});
  EXPECT_NEAR(along(off) - along(sound), 0.05 * (1.0 - along(sound)), 1e-9) << "of the length that was found";
  EXPECT_NE(off.verdict, kOk);
  const CalibrationState far_off = with_scale(sound, {0.3, kLeastScale}, theta, {});
  EXPECT_EQ(far_off.verdict, kDecalibrated);
  EXPECT_TRUE(far_off.named);
  const CalibrationState unknown = with_scale(sound, {}, theta, {});
  EXPECT_EQ(unknown.verdict, kCannotTell);
  EXPECT_EQ(unknown.by_epipolar, kOk);
  EXPECT_NEAR(std::sqrt(unknown.estimate.covariance(3, 3)) / theta.tail<3>().norm(), 0.5, 0.01);
}

/// @param scale  of the positions in the first `scaled` frames
CalibrationState judged_by_vision(const World& world, double scale, std::size_t scaled = SIZE_MAX) {
  CalibrationWatch watch({}, world.assumed, false);
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    Pose pose = world.poses[k];
    pose.p *= k < scaled ? scale : 1.0;
    watch.add(world.frames[k], pose, {});
  }
  return watch.report_at_once()->state;
}

/// Nobody knows how long the baseline is, but which way it points. A length that is unknown along the assumed
/// baseline was 50 % of an error across it.
TEST(CalibrationWatch, TellsWhichWayABaselineOfUnknownLengthPoints) {
  WorldOptions options;
  options.error = [](double) { return RigParameters(0.06 * RigParameters::Unit(4)); };
  const CalibrationState state = judged_by_vision(fly_past(options), 1.0);
  EXPECT_EQ(state.verdict, kDecalibrated);
  EXPECT_EQ(state.named, 4U);
  EXPECT_GT(state.effect.epipolar_px.low, 0.7 * state.effect.epipolar_px.size);
}

/// A trajectory whose scale is gone makes a baseline of next to nothing, and vergence of what is left.
TEST(CalibrationWatch, CannotTellWhereVisionHasLostItsScale) {
  const World world = fly_past(with_step(0.0, 0.0));
  const CalibrationState known = judged_by_vision(world, 1.1), lost = judged_by_vision(world, 0.2);
  EXPECT_EQ(known.verdict, kOk);
  EXPECT_FALSE(known.scale_is_lost);
  EXPECT_TRUE(lost.scale_is_lost);
  EXPECT_EQ(lost.verdict, kCannotTell);
  EXPECT_EQ(lost.by_depth, kCannotTell);
  EXPECT_FALSE(lost.named);
}

/// Epipolar lines need no scale. Of the trajectory's length nothing is claimed.
TEST(CalibrationWatch, ToldByEpipolarLinesARigIsDecalibratedWhateverVisionHasLost) {
  const World world = fly_past(with_step(0.0, 0.4));
  for (const double scale : {0.2, 3.0}) {
    const CalibrationState state = judged_by_vision(world, scale);
    EXPECT_TRUE(state.scale_is_lost);
    EXPECT_EQ(state.verdict, kDecalibrated);
    EXPECT_EQ(state.by_depth, kCannotTell);
    EXPECT_EQ(state.named, 0U);
    EXPECT_NEAR(state.estimate.delta(0), 0.4 * kDegree, 2.0 * state.estimate.sigma()(0));
    EXPECT_EQ(state.axes[0], kDecalibrated);
    EXPECT_EQ(state.axes[3], kCannotTell);
    EXPECT_LT(std::abs(state.estimate.delta(3)), 1.5 * state.estimate.sigma()(3));
  }
}

/// As the first one after a rest may. It made vergence of 0.15 degrees.
TEST(CalibrationWatch, AWindowThatHasLostItsScaleDoesNotBendWhatOthersTell) {
  const World world = fly_past(with_step(0.0, 0.0));
  const CalibrationState state = judged_by_vision(world, 3.0, world.frames.size() / 8);
  EXPECT_FALSE(state.scale_is_lost);
  EXPECT_EQ(state.verdict, kOk);
}

TEST(CalibrationWatch, AnAxisOfItsOwnToleranceCounts) {
  WatchOptions how;
  how.tolerance.axes[0] = Band{0.005 * kDegree, 0.02 * kDegree};
  EXPECT_EQ(judge_world(with_step(0.0, 0.06), how).last->state.verdict, kDecalibrated);
}

TEST(CalibrationWatch, RefusesOptionsThatAreNone) {
  WatchOptions how;
  how.window_s = 0.0;
  EXPECT_THROW(CalibrationWatch(how, testing::world_calibration(), true), std::invalid_argument);
}

}  // namespace
}  // namespace limber
