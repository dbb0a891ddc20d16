// SPDX-License-Identifier: MIT
#include "limber/health/learned_pixel_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stereo_world.hpp"

namespace limber {
namespace {

using testing::fly_past;
using testing::World;
using testing::WorldOptions;

LearnedPixelNoise after_seeing(const World& world, double begin_px = 1.0) {
  LearnedPixelNoise out(PixelNoise::Constant(begin_px), world.assumed);
  for (const StereoFrame& frame : world.frames) {
    out.see(frame);
  }
  return out;
}

/// Updates of a filter whose innovations are as large as white noise of `true_px` makes them.
void learn_white(LearnedPixelNoise& noise, double true_px, int frames) {
  for (int k = 0; k < frames; ++k) {
    const double assumed = noise.sigma_px()(0);
    noise.learn(200.0 * true_px * true_px / (assumed * assumed), 200.0);
  }
}

TEST(LearnedPixelNoise, BeginsWithWhatItIsTold) {
  const PixelNoise begin(0.4, 0.5, 0.6, 0.7);
  const LearnedPixelNoise noise(begin, testing::world_calibration());
  EXPECT_EQ(noise.sigma_px(), begin);
}

TEST(LearnedPixelNoise, SeesThatErrorsAreWhite) {
  const LearnedPixelNoise noise = after_seeing(fly_past({}));
  EXPECT_NEAR(noise.report().correlation, 0.0, 0.05);
  EXPECT_NEAR(noise.persistence(), 1.0, 0.5);
}

TEST(LearnedPixelNoise, SeesWhatStaysWithTracks) {
  WorldOptions options;
  options.white_px = 0.1;
  options.per_track_px = 0.3;  // of the right pixel; the white part is that of both pixels
  const double lasting = 0.09 / (0.09 + 2.0 * 0.01);
  EXPECT_NEAR(after_seeing(fly_past(options)).report().correlation, lasting, 0.1);
}

/// Of the assumed variance: what so many frames leave of it is what lasts, of a single frame's variance.
TEST(LearnedPixelNoise, KnowsHowManyFramesTellAsMuchAsWhatLastsLetsKnow) {
  WorldOptions options;
  options.white_px = 0.1;
  options.per_track_px = 0.3;
  const LearnedPixelNoise lasting = after_seeing(fly_past(options)), white = after_seeing(fly_past({}));
  EXPECT_NEAR(lasting.persistence() / lasting.telling_frames(), lasting.report().correlation, 0.1);
  EXPECT_GT(white.telling_frames(), 3.0 * lasting.telling_frames());
}

TEST(LearnedPixelNoise, TakesAWrongRigForNoError) {
  WorldOptions options;
  options.error = [](double) { return RigParameters(0.01, 0.03, 0.01, 0.01, 0.0, 0.0); };
  EXPECT_LT(after_seeing(fly_past(options)).report().correlation, 0.2);
}

TEST(LearnedPixelNoise, TakesARigThatIsOffByDegreesForNoErrorBesideSmallOnes) {
  WorldOptions options;
  options.white_px = 0.05;
  for (const double sign : {-1.0, 1.0}) {
    options.error = [sign](double) { return RigParameters(0.02 * sign, 0.05, 0.02, 0.0, 0.01, 0.01 * sign); };
    EXPECT_LT(after_seeing(fly_past(options)).report().correlation, 0.1) << sign;
  }
}

TEST(LearnedPixelNoise, IsNotMisledByMismatches) {
  WorldOptions options;
  options.mismatches = 0.2;
  EXPECT_LT(after_seeing(fly_past(options)).report().correlation, 0.1);
}

TEST(LearnedPixelNoise, SeesWhatStaysWithTracksBesideMismatches) {
  WorldOptions options;
  options.white_px = 0.1;
  options.per_track_px = 0.3;
  const double without = after_seeing(fly_past(options)).report().correlation;
  for (const double mismatches : {0.05, 0.1, 0.2}) {
    options.mismatches = mismatches;
    EXPECT_NEAR(after_seeing(fly_past(options)).report().correlation, without, 0.15) << mismatches;
  }
}

TEST(LearnedPixelNoise, FindsTheSizeOfWhiteNoise) {
  for (const double true_px : {0.15, 0.5, 2.0}) {
    LearnedPixelNoise noise = after_seeing(fly_past({}));
    learn_white(noise, true_px, 300);
    EXPECT_NEAR(noise.report().sigma_px / true_px, 1.0, 0.2) << true_px;
  }
}

TEST(LearnedPixelNoise, AssumesMoreWhereErrorsLast) {
  WorldOptions options;
  options.white_px = 0.1;
  options.per_track_px = 0.4;
  LearnedPixelNoise lasting = after_seeing(fly_past(options));
  learn_white(lasting, 0.3, 300);
  EXPECT_GT(lasting.report().sigma_px, 0.7);
  EXPECT_LT(lasting.report().sigma_px, 1.2);
}

/// What was learned of so much that lasts [px], whoever else is beside it.
PixelNoiseReport learned_of(double per_track_px, double seconds) {
  WorldOptions options;
  options.white_px = 0.1;
  options.per_track_px = per_track_px;
  options.seconds = seconds;
  LearnedPixelNoise noise = after_seeing(fly_past(options));
  learn_white(noise, 0.1 + 0.5 * per_track_px, 300);
  return noise.report();
}

TEST(LearnedPixelNoise, DoubtsLengthsByWhatLastsHoweverManyFramesThereAre) {
  EXPECT_EQ(LearnedPixelNoise(PixelNoise::Constant(1.0), testing::world_calibration()).report().length_sigma,
            0.0);
  const double of_lasting = learned_of(0.4, 10.0).length_sigma;
  EXPECT_GT(of_lasting, 0.01);
  EXPECT_LT(of_lasting, 0.1);
  EXPECT_LT(learned_of(0.0, 10.0).length_sigma, 0.2 * of_lasting);
  EXPECT_NEAR(learned_of(0.4, 40.0).length_sigma / of_lasting, 1.0, 0.1);
}

/// A pair that is mismatched along its line seems as near as anything, and would count for many.
TEST(LearnedPixelNoise, DoubtsLengthsByParallaxesOfPointsThatAreMatchedRight) {
  const auto parallax = [](bool mismatches) {
    World world = fly_past({});
    for (std::size_t n = 0; mismatches && n < world.frames.size(); ++n) {
      for (StereoObservation& o : world.frames[n].observations) {
        if ((static_cast<std::size_t>(o.track_id) + n) % 10 == 0) {
          o.uv_cam1.x() -= 200.0;
        }
      }
    }
    const LearnedPixelNoise noise = after_seeing(world);
    const PixelNoiseReport report = noise.report();
    return report.sigma_px * std::sqrt(report.correlation / (0.93 * noise.persistence())) /
           report.length_sigma;
  };
  // Of points 2 to 12 m ahead, evenly: the mean of squared disparities over that of disparities. From the
  // side it is less, and near points are soon gone.
  const double ahead = 458.0 * 0.11 * (1.0 / 2.0 - 1.0 / 12.0) / std::log(12.0 / 2.0), seen = parallax(false);
  EXPECT_GT(seen, 0.6 * ahead);
  EXPECT_LT(seen, ahead);
  EXPECT_NEAR(parallax(true) / seen, 1.0, 0.25);
}

TEST(LearnedPixelNoise, WhatLastsWeighsAsLongAsPointsAreSeen) {
  WorldOptions options;
  options.white_px = 0.1;
  options.per_track_px = 0.4;
  options.seconds = 20.0;
  const World world = fly_past(options);
  World cut = world;  // no track is longer than eight frames
  for (std::size_t k = 0; k < cut.frames.size(); ++k) {
    for (StereoObservation& o : cut.frames[k].observations) {
      o.track_id = 1000 * o.track_id + static_cast<std::int64_t>(k / 8);
    }
  }
  const double lasting = after_seeing(world).report().correlation / 0.93;
  // An AR(1) of 0.93 over ten frames counts 11.3-fold, for ever 27.6-fold.
  EXPECT_NEAR(after_seeing(cut).persistence(), 1.0 + 10.3 * lasting, 0.3);
  EXPECT_GT(after_seeing(world).persistence(), 1.0 + 15.0 * lasting);
  EXPECT_LT(after_seeing(world).persistence(), 1.0 + 26.6 * lasting);
}

TEST(LearnedPixelNoise, GoesBelowTheBeginningOnlyWhereItKnowsWhetherErrorsLast) {
  LearnedPixelNoise blind(PixelNoise::Constant(1.0), testing::world_calibration());
  learn_white(blind, 0.1, 300);
  EXPECT_EQ(blind.sigma_px(), PixelNoise::Constant(1.0));
  learn_white(blind, 2.0, 300);
  EXPECT_GT(blind.report().sigma_px, 2.0);
}

TEST(LearnedPixelNoise, StaysWithinBoundsAndKeepsItsHeadAmongNonsense) {
  LearnedPixelNoise noise = after_seeing(fly_past({}));
  learn_white(noise, 1e3, 300);
  EXPECT_LE(noise.report().sigma_px, 5.0);
  const PixelNoise before = noise.sigma_px();
  noise.learn(std::nan(""), 200.0);
  noise.learn(1.0, 3.0);  // too few rows to tell
  EXPECT_EQ(noise.sigma_px(), before);
  LearnedPixelNoise wide(PixelNoise::Constant(8.0), testing::world_calibration());
  learn_white(wide, 1e3, 300);
  EXPECT_EQ(wide.sigma_px(), PixelNoise::Constant(8.0));
}

}  // namespace
}  // namespace limber
