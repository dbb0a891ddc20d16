// SPDX-License-Identifier: MIT
#include "limber/health/rig_window.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "health/stereo_world.hpp"
#include "limber/health/robust_estimate.hpp"
#include "sanitized.hpp"

namespace limber {
namespace {

using testing::fly_past;
using testing::World;
using testing::WorldOptions;

constexpr double kOneDegree = std::numbers::pi / 180.0;

std::optional<RigEvidence> evidence_of(WindowFit fit) {
  while (!fit.done()) {
    fit.advance();
  }
  return fit.evidence();
}

std::vector<RigEvidence> windows_of(const World& world, std::size_t frames = 50) {
  std::vector<RigEvidence> out;
  RigWindow window(world.assumed);
  for (std::size_t k = 0; k < world.frames.size(); ++k) {
    window.add(world.frames[k], world.poses[k], true);
    if ((k + 1) % frames == 0) {
      if (const auto evidence = evidence_of(window.close())) {
        append(*evidence, out);
      }
    }
  }
  return out;
}

RigEstimate estimate_of(const World& world) {
  const RigParameters& theta = world.assumed.theta;
  return robust_estimate(windows_of(world), theta, true).rig(theta);
}

RigParameters some_error() {
  RigParameters out;
  out << 0.3 * kOneDegree, -0.3 * kOneDegree, 0.2 * kOneDegree, 0.003, -0.003, 0.002;
  return out;
}

TEST(RigWindow, FindsAConstantErrorOfEveryAxis) {
  WorldOptions options;
  options.seconds = 5.0;
  options.error = [](double) { return some_error(); };
  const World world = fly_past(options);
  const RigEstimate found = estimate_of(world);
  const RigParameters off = found.delta - some_error();
  EXPECT_LT(off.cwiseQuotient(found.sigma()).cwiseAbs().maxCoeff(), 4.0) << off.transpose();
  EXPECT_LT(off.head<3>().cwiseAbs().maxCoeff(), 0.02 * kOneDegree);
  EXPECT_LT(off.tail<3>().cwiseAbs().maxCoeff(), 2e-3);
}

/// Mean over seeds of vergence [deg] and length [mm] that are found of a sound rig.
Eigen::Vector2d mean_of_slow_flights(double speed, double mismatches) {
  constexpr int kSeeds = 12;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    WorldOptions options;
    options.seconds = 5.0;
    options.speed = speed;
    options.white_px = 0.2;
    options.wandering_px = 0.7;
    options.per_track_px = 0.4;
    options.mismatches = mismatches;
    options.seed = seed;
    const RigParameters delta = estimate_of(fly_past(options)).delta;
    sum += Eigen::Vector2d(delta(1) / kOneDegree, 1e3 * delta(3)) / kSeeds;
  }
  return sum;
}

/// Depths by a short way are off, and so are those by the right pixel: with either in the derivative the
/// baseline is found too short or too long, and the cameras turned.
TEST(RigWindow, OfSlowMotionTheRigIsNeitherLongerNorTurned) {
  for (const double mismatches : {0.0, 0.1}) {
    for (const double speed : {0.1, 0.3}) {
      const Eigen::Vector2d mean = mean_of_slow_flights(speed, mismatches);
      EXPECT_NEAR(mean.x(), 0.0, 0.015) << speed << ", " << mismatches;
      EXPECT_NEAR(mean.y(), 0.0, 1.0) << speed << ", " << mismatches;
    }
  }
}

TEST(RigWindow, FindsAnErrorThatIsFarFromLinear) {
  // A baseline turned by 20 to 45 degrees, and by what is left of it: linear about the assumed rig 4 % off.
  for (const Eigen::Vector3d& error :
       {Eigen::Vector3d{0.0, -0.04, 0.0}, {0.0, 0.0, 0.11}, {0.03, 0.0, 0.0}}) {
    WorldOptions options;
    options.seconds = 5.0;
    options.error = [&](double) {
      RigParameters out = RigParameters::Zero();
      out.tail<3>() = error;
      return out;
    };
    const RigEstimate found = estimate_of(fly_past(options));
    const Eigen::Vector3d off = found.delta.tail<3>() - error;
    EXPECT_LT(off.cwiseQuotient(found.sigma().tail<3>()).cwiseAbs().maxCoeff(), 3.5) << off.transpose();
    EXPECT_LT(off.norm(), 0.02 * error.norm()) << off.transpose();
  }
}

TEST(RigWindow, MismatchesDoNotMoveIt) {
  WorldOptions options;
  options.seconds = 5.0;
  options.mismatches = 0.15;
  options.error = [](double) { return some_error(); };
  const World world = fly_past(options);
  const RigEstimate found = estimate_of(world);
  EXPECT_LT((found.delta - some_error()).head<3>().cwiseAbs().maxCoeff(), 0.03 * kOneDegree);
}

/// Bounded influences of a third of all points turn a sound rig: of eleven drones four were decalibrated.
TEST(RigWindow, ThatIsMostlyMismatchedSaysNothing) {
  WorldOptions options;
  options.seconds = 5.0;
  options.mismatches = 0.35;
  EXPECT_TRUE(windows_of(fly_past(options)).empty());
}

/// A jump of the rig: the frames behind it leave the lines of those before, all of their points.
TEST(RigWindow, WhoseRigJumpsIsNotMismatched) {
  WorldOptions options;
  options.seconds = 2.5;
  options.error = [](double t) {
    RigParameters out = RigParameters::Zero();
    out(0) = t > 1.7 ? kOneDegree : 0.0;
    return out;
  };
  EXPECT_EQ(windows_of(fly_past(options)).size(), 1u);
}

/// What moves a point across its line grows with its disparity: a few wrong ones had fitted themselves, and
/// the rig had followed.
TEST(RigWindow, AFewWrongMatchesThatStayDoNotTurnIt) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    WorldOptions options;
    options.seconds = 5.0;
    options.seed = seed;
    World world = fly_past(options);
    for (StereoFrame& frame : world.frames) {
      for (StereoObservation& point : frame.observations) {
        if (point.track_id % 40 == 3) {
          point.uv_cam1 += Eigen::Vector2d(400.0, 100.0);
        }
      }
    }
    const RigEstimate found = estimate_of(world);
    EXPECT_LT(found.delta.cwiseQuotient(found.sigma()).cwiseAbs().maxCoeff(), 4.0)
        << seed << ": " << found.delta.transpose();
    EXPECT_LT(found.delta.tail<3>().cwiseAbs().maxCoeff(), 2e-3) << seed;
  }
}

/// Of cameras that stand one above the other ax is the vergence, which depths alone tell, and lines tell ay.
TEST(RigWindow, FindsAConstantErrorOfAPairAboveEachOther) {
  WorldOptions options;
  options.seconds = 5.0;
  options.above = true;
  options.error = [](double) { return some_error(); };
  const RigEstimate found = estimate_of(fly_past(options));
  const RigParameters off = found.delta - some_error();
  EXPECT_LT(off.cwiseQuotient(found.sigma()).cwiseAbs().maxCoeff(), 4.0) << off.transpose();
  EXPECT_LT(off.head<3>().cwiseAbs().maxCoeff(), 0.02 * kOneDegree);

  WorldOptions still = options;
  still.speed = 0.0;
  still.seconds = 2.5;
  const RigParameters sigma = estimate_of(fly_past(still)).sigma();
  EXPECT_LT(sigma(1), 0.1 * kOneDegree);
  EXPECT_GT(sigma(0), 0.3 * kOneDegree);
}

TEST(RigWindow, WithoutMotionTheDepthIsNotKnown) {
  WorldOptions options;
  options.seconds = 2.5;
  options.speed = 0.0;
  const World world = fly_past(options);
  const std::vector<RigEvidence> windows = windows_of(world);
  ASSERT_EQ(windows.size(), 1u);
  EXPECT_EQ(windows.front().deep, 0u);
  const RigParameters sigma = estimate_of(world).sigma();
  EXPECT_GT(sigma(3), 0.04);              // of 0.11 m: the length of the baseline
  EXPECT_LT(sigma(2), 0.1 * kOneDegree);  // roll shows in the epipolar lines
}

TEST(RigWindow, ErrorsThatTracksAndPlacesShareMakeItAsUnsureAsItIs) {
  // Mean square of z over axes and seeds: 1 if the covariance is right. Pixels taken for independent claim
  // far less than is there.
  double robust = 0.0, naive = 0.0;
  constexpr int kSeeds = 12;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    WorldOptions options;
    options.seconds = 2.5;
    options.per_track_px = 0.4;
    options.per_cell_px = 0.15;
    options.seed = static_cast<unsigned>(seed);
    const World world = fly_past(options);
    const std::vector<RigEvidence> windows = windows_of(world);
    const RigEstimate found = estimate_of(world);
    robust += found.delta.cwiseQuotient(found.sigma()).squaredNorm() / (6.0 * kSeeds);
    const RigParameters scale = plausible_error(0.11);
    const RigParameters white = NormalEquations::Matrix(windows.front().all.information.inverse())
                                    .diagonal()
                                    .head<6>()
                                    .cwiseSqrt()
                                    .cwiseProduct(scale);
    naive += found.delta.cwiseQuotient(white).squaredNorm() / (6.0 * kSeeds);
  }
  EXPECT_LT(robust, 2.0);
  EXPECT_GT(robust, 0.3);
  EXPECT_GT(naive, 5.0);
}

/// Twenty places of the image are few for seven unknowns, which follow what the lens does in them: with their
/// scores as they are the mean z² is 1.6.
TEST(RigWindow, AFewPlacesMakeItAsUnsureAsItIs) {
  if (testing::kSanitized) {
    GTEST_SKIP() << "a long statistic of what the other tests run, too";
  }
  double z2 = 0.0;
  constexpr int kSeeds = 24;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    WorldOptions options;
    options.seconds = 12.5;
    options.white_px = 0.1;
    options.per_cell_px = 0.4;
    options.seed = static_cast<unsigned>(seed);
    const RigEstimate found = estimate_of(fly_past(options));
    const RigParameters z = found.delta.cwiseQuotient(found.sigma());
    z2 += (z.head<3>().squaredNorm() + z.tail<2>().squaredNorm()) / (5.0 * kSeeds);  // all but the length
  }
  EXPECT_LT(z2, 1.4);
  EXPECT_GT(z2, 0.4);
}

/// Ten tracks are hardly more than the seven unknowns, which follow them: what is left of their errors would
/// make the covariance too small, and a rig be said to change wherever few points are in sight.
TEST(RigWindow, AFewTracksMakeItAsUnsureAsItIs) {
  double z2 = 0.0;
  constexpr int kSeeds = 40;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    WorldOptions options;
    options.seconds = 2.5;
    options.speed = 0.3;  // the same ones all the time
    options.points = 10;
    options.per_track_px = 0.4;
    options.seed = seed;
    const World world = fly_past(options);
    const std::vector<RigEvidence> windows = windows_of(world);
    const BetaEstimate found = robust_estimate(windows, world.assumed.theta, true);
    for (Eigen::Index k = 0; k < 3; ++k) {
      z2 += found.beta(k) * found.beta(k) / found.covariance(k, k) / (3.0 * kSeeds);
    }
  }
  EXPECT_LT(z2, 1.0);
  EXPECT_GT(z2, 0.05);
}

/// Sum of squares of z of the step of the last three windows, on three axes.
double square_of_step(const std::vector<RigEvidence>& windows, const RigParameters& theta) {
  const BetaEstimate step = robust_steps(windows, {windows.size() - 3}, theta, true).front();
  double out = 0.0;
  for (Eigen::Index k = 0; k < 3; ++k) {
    out += step.beta(k) * step.beta(k) / step.covariance(k, k);
  }
  return out;
}

/// A track that is in sight for seconds has one error in several windows, which are not independent. The mean
/// square of z is 1 where the covariance is right.
TEST(RigWindow, TracksThatStayMakeAStepAsUnsureAsItIs) {
  if (testing::kSanitized) {
    GTEST_SKIP() << "a long statistic of what the other tests run, too";
  }
  constexpr unsigned kSeeds = 100;
  double shared = 0.0, unaware = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    WorldOptions options;
    options.seconds = 25.0;
    options.points = 12;
    options.per_track_px = 0.4;
    options.seed = seed;
    const World world = fly_past(options);
    std::vector<RigEvidence> windows = windows_of(world);
    shared += square_of_step(windows, world.assumed.theta) / (3.0 * kSeeds);
    for (RigEvidence& window : windows) {
      window.with_earlier.clear();
    }
    unaware += square_of_step(windows, world.assumed.theta) / (3.0 * kSeeds);
  }
  EXPECT_NEAR(shared, 1.0, 0.2);
  EXPECT_GT(unaware, 1.3);
}

/// Scores that tracks have, and those that they are expected to have by their weights and a common variance.
TEST(RigWindow, ErrorsOfTracksAreAsLargeAsTheirScores) {
  double had = 0.0, expected = 0.0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    WorldOptions options;
    options.seconds = 2.5;
    options.per_track_px = 0.4;
    options.seed = seed;
    const RigEvidence window = windows_of(fly_past(options)).front();
    const NormalEquations::Matrix inverse = window.all.information.inverse();
    had += (inverse * window.products.tracks).trace();
    for (std::size_t kind = 0; kind < kKinds; ++kind) {
      expected += window.errors.variance(kind) * (inverse * window.products.of_a_pixel[kind]).trace();
    }
  }
  EXPECT_NEAR(expected / had, 1.0, 0.2);
}

/// A handful of tracks may by chance agree far better than their errors are small.
TEST(RigWindow, TracksThatAgreeByChanceAreBelievedByHalf) {
  RigEvidence window;
  window.all.information = 1e4 * NormalEquations::Matrix::Identity();
  window.products.of_a_pixel[0] = window.all.information;
  window.errors.squares[0] = window.errors.weights[0] = 1.0;
  const auto variance = [&](double share) {
    window.products.tracks = window.products.both = share * window.all.information;
    return robust_estimate({window}, testing::world_calibration().theta, true).covariance(0, 0);
  };
  EXPECT_NEAR(variance(0.0) / variance(1.0), 0.5, 0.01);
  EXPECT_NEAR(variance(3.0) / variance(1.0), 2.0, 0.01);
}

TEST(RigWindow, WithTooFewPointsSaysNothing) {
  WorldOptions options;
  options.seconds = 0.5;
  options.points = 5;
  RigWindow window(testing::world_calibration());
  const World world = fly_past(options);
  window.add(world.frames[0], world.poses[0], true);
  EXPECT_FALSE(evidence_of(window.close()));
  EXPECT_TRUE(window.empty());
}

}  // namespace
}  // namespace limber
