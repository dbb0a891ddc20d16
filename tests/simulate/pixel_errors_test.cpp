// SPDX-License-Identifier: MIT
// Errors of pixels beyond white noise: their statistics, and that nothing else moves.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"
#include "shipped_scenario.hpp"
#include "simulate/recordings.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;
using testing::same;

/// The drone without white noise.
Scenario drone(double duration = 10.0) {
  Scenario s = testing::shipped("drone_none");
  s.noise.pixel = 0.0;
  s.duration = duration;
  return s;
}

/// Errors by track, in time order, of tracks seen at least `least` times.
std::map<std::int64_t, std::vector<Vector4d>> errors_by_track(const Recording& recording, std::size_t least) {
  std::map<std::int64_t, std::vector<Vector4d>> tracks;
  testing::visit_residuals(recording, [&](const StereoFrame&, const StereoObservation& o, const Vector4d& r) {
    tracks[o.track_id].push_back(r);
  });
  std::erase_if(tracks, [&](const auto& track) { return track.second.size() < least; });
  return tracks;
}

TEST(PixelErrors, PerTrackAreConstantAndOfTheGivenSize) {
  Scenario s = drone();
  s.pixels.per_track = 0.3;
  double sum = 0.0, product = 0.0;
  std::size_t n = 0;
  for (std::uint64_t run = 0; run < 4; ++run) {
    for (const auto& [id, errors] : errors_by_track(simulate(s, 1, run), 2)) {
      for (const Vector4d& error : errors) {
        ASSERT_LT((error - errors.front()).norm(), 1e-9);
      }
      sum += errors.front().squaredNorm();
      product += errors.front()[1] * errors.front()[3];
      ++n;
    }
  }
  ASSERT_GT(n, 500u);
  const double draws = 4.0 * static_cast<double>(n);
  EXPECT_NEAR(sum / draws, 0.09, 0.09 * 5.0 * std::sqrt(2.0 / draws));
  EXPECT_NEAR(product / static_cast<double>(n), 0.0, 0.09 * 5.0 / std::sqrt(static_cast<double>(n)));
}

TEST(PixelErrors, CorrelatedHaveTheGivenVarianceAndLagOneCorrelation) {
  Scenario s = drone(30.0);
  s.pixels.correlated = 0.4;
  s.pixels.correlated_coefficient = 0.8;
  double variance = 0.0, lag = 0.0, steps = 0.0, n = 0.0;
  testing::visit_residuals(simulate(s, 1),
                           [&](const StereoFrame&, const StereoObservation&, const Vector4d& r) {
                             variance += r.squaredNorm() / 4.0;
                             n += 1.0;
                           });
  // Neighbours in a track of which no frame is missing.
  const Recording recording = simulate(s, 1);
  std::map<std::int64_t, std::pair<std::int64_t, Vector4d>> last;
  testing::visit_residuals(recording,
                           [&](const StereoFrame& f, const StereoObservation& o, const Vector4d& r) {
                             const auto it = last.find(o.track_id);
                             if (it != last.end() && f.t_ns - it->second.first == 50'000'000) {
                               lag += r.dot(it->second.second) / 4.0;
                               steps += 1.0;
                             }
                             last[o.track_id] = {f.t_ns, r};
                           });
  ASSERT_GT(n, 20000.0);
  // An AR(1) of 0.8 has (1 - 0.64) / (1 + 0.64) as many independent squares.
  const double independent = 4.0 * n * 0.36 / 1.64;
  EXPECT_NEAR(variance / n, 0.16, 0.16 * 5.0 * std::sqrt(2.0 / independent));
  EXPECT_NEAR(lag / steps / (variance / n), 0.8, 0.02);
}

TEST(PixelErrors, OfTheLensAreAFunctionOfThePixelWithTheGivenRms) {
  Scenario s = drone(1.0);
  s.pixels.field = 0.2;
  const Recording recording = simulate(s, 1);
  // Points that land within 15 px of each other have nearly the same error, whichever frame they are in.
  struct Seen {
    double u, v, error_u, error_v;
    [[nodiscard]] double squared_apart(const Seen& o) const {
      return (u - o.u) * (u - o.u) + (v - o.v) * (v - o.v);
    }
    [[nodiscard]] double squared_difference(const Seen& o) const {
      return (error_u - o.error_u) * (error_u - o.error_u) + (error_v - o.error_v) * (error_v - o.error_v);
    }
  };
  std::vector<Seen> seen;
  testing::visit_residuals(recording, [&](const StereoFrame&, const StereoObservation& o, const Vector4d& r) {
    seen.push_back({o.uv_cam0.x(), o.uv_cam0.y(), r[0], r[1]});
  });
  double near = 0.0, apart = 0.0, pairs = 0.0, all = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double squared = seen[i].squared_difference(seen[k]);
      apart += squared;
      all += 1.0;
      if (seen[i].squared_apart(seen[k]) < 15.0 * 15.0) {
        near += squared;
        pairs += 1.0;
      }
    }
  }
  ASSERT_GT(pairs, 1000.0);
  EXPECT_LT(std::sqrt(near / pairs), 0.06);
  EXPECT_GT(std::sqrt(apart / all), 0.15);
}

TEST(PixelErrors, OfTheLensFillTheImageWithTheGivenRms) {
  Scenario s = drone(30.0);
  s.pixels.field = 0.2;
  double sum = 0.0, n = 0.0;
  for (std::uint64_t run = 0; run < 12; ++run) {
    testing::visit_residuals(simulate(s, 1, run),
                             [&](const StereoFrame&, const StereoObservation&, const Vector4d& r) {
                               sum += r.squaredNorm() / 4.0;
                               n += 1.0;
                             });
  }
  EXPECT_NEAR(std::sqrt(sum / n), 0.2, 0.02);  // points are not spread evenly
}

TEST(PixelErrors, ReplaceTheGivenShareOfPoints) {
  Scenario s = drone(20.0);
  s.pixels.mismatches = 0.1;
  double wrong = 0.0, left = 0.0, n = 0.0;
  testing::visit_residuals(
      simulate(s, 1), [&](const StereoFrame&, const StereoObservation& o, const Vector4d& r) {
        n += 1.0;
        wrong += r.norm() > 1.0 ? 1.0 : 0.0;
        left += r.head<2>().norm() > 1.0 ? 1.0 : 0.0;
        ASSERT_TRUE(r.head<2>().norm() < 1e-9 || r.tail<2>().norm() < 1e-9) << "one camera at most";
        ASSERT_TRUE(in_image(s.rig.cam0, o.uv_cam0) && in_image(s.rig.cam1, o.uv_cam1));
      });
  EXPECT_NEAR(wrong / n, 0.1, 5.0 * std::sqrt(0.09 / n));
  EXPECT_NEAR(left / wrong, 0.5, 5.0 * std::sqrt(0.25 / wrong));
}

TEST(PixelErrors, LeaveTruthOtherSensorsAndWhiteNoiseAsTheyAre) {
  Scenario s = drone(3.0);
  s.noise.pixel = 0.5;
  const Recording white = simulate(s, 2, 3);
  s.pixels = {.per_track = 0.3, .correlated = 0.2, .field = 0.2};
  const Recording real = simulate(s, 2, 3);
  EXPECT_TRUE(same(white.imu, real.imu));
  EXPECT_TRUE(same(white.truth.motion.states, real.truth.motion.states));
  EXPECT_TRUE(same(white.truth.rig, real.truth.rig));
  EXPECT_EQ(white.truth.landmarks, real.truth.landmarks);
  s.noise.pixel = 0.0;
  const Recording rest = simulate(s, 2, 3);
  ASSERT_EQ(white.frames.size(), real.frames.size());
  s.pixels = {};
  const Recording exact = simulate(s, 2, 3);
  for (std::size_t j = 0; j < real.frames.size(); ++j) {
    for (std::size_t i = 0; i < real.frames[j].observations.size(); ++i) {
      const auto uv = [&](const Recording& r) { return r.frames[j].observations.at(i).uv_cam1; };
      ASSERT_LT((uv(white) + uv(rest) - uv(exact) - uv(real)).norm(), 1e-9);
      ASSERT_GT((uv(rest) - uv(exact)).norm(), 0.0);
    }
  }
}

TEST(RealisticPixels, AreCorrelatedAsOnRealTracks) {
  Scenario s = drone(30.0);
  set_pixels(s, PixelPreset::kRealistic);
  EXPECT_TRUE(s.filter.gate);
  double total = 0.0, between = 0.0, lag = 0.0, n = 0.0;
  for (std::uint64_t run = 0; run < 4; ++run) {
    const Recording recording = simulate(s, 1, run);
    EXPECT_FALSE(recording.pixel_noise.has_value());
    // Tracks of five seconds; the error of v1 - v0, which is the epipolar one here.
    for (const auto& [id, errors] : errors_by_track(recording, 100)) {
      double mean = 0.0;
      for (const Vector4d& e : errors) {
        mean += (e[3] - e[1]) / static_cast<double>(errors.size());
      }
      between += mean * mean * static_cast<double>(errors.size());
      for (std::size_t i = 0; i < errors.size(); ++i) {
        const double e = errors[i][3] - errors[i][1];
        total += e * e;
        lag += i > 0 ? e * (errors[i - 1][3] - errors[i - 1][1]) : 0.0;
        n += 1.0;
      }
    }
  }
  ASSERT_GT(n, 20000.0);
  EXPECT_NEAR(between / total, 0.70, 0.07);  // KITTI: 63-76 %
  EXPECT_NEAR(lag / total, 0.92, 0.03);      // KITTI: 0.91-0.95
}

// ---- a moving body

TEST(MovingBody, TakesItsShareOfThePointsAlongRigidly) {
  Scenario s = drone(5.0);
  const Recording still = simulate(s, 1);
  s.world.moving_body = MovingBodyScenario{.share = 0.4, .speed = 1.0, .radius = 2.0, .start = 1.0};
  const Recording moving = simulate(s, 1);
  EXPECT_TRUE(same(still.truth.motion.states, moving.truth.motion.states));
  const auto share =
      static_cast<double>(moving.truth.landmarks.size()) / static_cast<double>(still.truth.landmarks.size());
  EXPECT_NEAR(share, 0.6, 0.2);  // those that move have no true place
  std::size_t moved = 0, seen = 0;
  for (std::size_t j = 0; j < still.frames.size(); ++j) {
    std::map<std::int64_t, Vector2d> before;
    for (const StereoObservation& o : still.frames[j].observations) {
      before[o.track_id] = o.uv_cam0;
    }
    for (const StereoObservation& o : moving.frames[j].observations) {
      const auto it = before.find(o.track_id);
      if (it == before.end()) {
        continue;
      }
      const bool same_place = it->second == o.uv_cam0;
      if (still.frames[j].t_ns <= 1'000'000'000 || moving.truth.landmarks.contains(o.track_id)) {
        ASSERT_TRUE(same_place || !moving.truth.landmarks.contains(o.track_id));
        ASSERT_LT((it->second - o.uv_cam0).norm(), 1e-9);
      } else {
        moved += same_place ? 0 : 1;
        ++seen;
      }
    }
  }
  ASSERT_GT(seen, 500u);
  EXPECT_EQ(moved, seen);
}

}  // namespace
}  // namespace limber
