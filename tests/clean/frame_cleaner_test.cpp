// SPDX-License-Identifier: MIT
#include "limber/clean/frame_cleaner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "clean/cleaned_frames.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/read_recording.hpp"
#include "real_data.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

using testing::cleaned;
using testing::Cleaned;
using testing::Frames;
using testing::kStepNs;
using testing::matched_in;
using testing::rig_of;
using testing::Tracks;
using testing::tracks_of;

/// Six tracks over a few frames; those of a frame in `stale` stand where they stood before, and a new one
/// comes.
Frames with_stale_frames(const std::vector<std::size_t>& stale, std::size_t count) {
  Frames frames;
  double moved = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const bool is_stale = std::find(stale.begin(), stale.end(), k) != stale.end();
    moved += is_stale ? 0.0 : 1.25;
    StereoFrame frame{static_cast<std::int64_t>(k) * kStepNs, {}};
    for (std::int64_t id = 0; id < 6; ++id) {
      const Vector2d uv(20.0 + moved, 10.0 * static_cast<double>(id));
      frame.observations.push_back({id, uv, uv, true, true});
    }
    if (is_stale) {
      frame.observations.push_back(
          {static_cast<std::int64_t>(100 + k), {50.0, 50.0}, {45.0, 50.0}, true, true});
    }
    frames.push_back(frame);
  }
  return frames;
}

TEST(FrameCleaner, EndsTracksThatWereNotTrackedIntoAFrame) {
  const auto [frames, report] = cleaned(with_stale_frames({2, 4}, 6), rig_of(0.1));
  EXPECT_EQ(tracks_of(frames[1]), (Tracks{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(tracks_of(frames[2]), (Tracks{102}));
  const Tracks renamed = tracks_of(frames[3]);
  EXPECT_EQ(tracks_of(frames[4]), (Tracks{104}));
  EXPECT_EQ(renamed.size(), 6u);
  for (const std::int64_t id : tracks_of(frames[5])) {
    EXPECT_EQ(std::count(renamed.begin(), renamed.end(), id), 0) << "renamed once more";
    EXPECT_LT(id, 0) << "no front end counts like that";
  }
  EXPECT_EQ(report.stale_frames, 2u);
  EXPECT_EQ(report.stale_points, 12u);
  EXPECT_THAT(in_words(report), ElementsAre(HasSubstr("in 2 of 6 frames")));
}

TEST(FrameCleaner, LeavesARigAloneThatStandsStillWithoutNoise) {
  const Frames still = with_stale_frames({1, 2, 3, 4}, 6);
  const Cleaned out = cleaned(still, rig_of(0.1));
  for (std::size_t k = 0; k < still.size(); ++k) {
    EXPECT_EQ(tracks_of(out.frames[k]), tracks_of(still[k])) << k;
  }
}

/// Points at 2 to 30 m that come nearer; from frame 2 on the true rig is another one, or the right pixels of
/// the first `leaping` points stand where those of a point at another depth would.
struct Leap {
  RigParameters jump = RigParameters::Zero();
  std::int64_t leaping = 0;
  double factor = 1.0;
  std::int64_t step_ns = kStepNs;
  std::size_t back = 5;   // the frame in which they stand where they did
  std::size_t count = 5;  // of frames
};

Frames with_leap(const StereoCalibration& rig, const Leap& leap) {
  Frames frames;
  for (std::size_t k = 0; k < leap.count; ++k) {
    const RigParameters theta = k >= 2 ? RigParameters(rig.theta + leap.jump) : rig.theta;
    const Pose T_cam1_cam0 = pose_from_rig(theta);
    StereoFrame frame{static_cast<std::int64_t>(k) * leap.step_ns, {}};
    for (std::int64_t id = 0; id < 30; ++id) {
      const double x = static_cast<double>(id % 6), y = static_cast<double>(id / 6);
      const Vector2d uv(60.0 + 90.0 * x + 1.5 * static_cast<double>(k), 60.0 + 70.0 * y);
      const double depth =
          2.0 + 28.0 * static_cast<double>(id * 7 % 30) / 30.0 - 0.02 * static_cast<double>(k);
      const bool leapt = k >= 2 && k < leap.back && id < leap.leaping;
      const double shown = leapt ? depth / leap.factor : depth;
      const Vector3d bearing = unproject(rig.cam0, uv).value();
      const auto right = project(rig.cam1, T_cam1_cam0 * Vector3d(bearing * shown / bearing.z()));
      frame.observations.push_back({id, uv, right.value().uv, true, true});
    }
    frames.push_back(frame);
  }
  return frames;
}

TEST(FrameCleaner, EndsMatchesThatLeapTogether) {
  const StereoCalibration rig = rig_of(0.5);
  for (const double factor : {2.1, 0.4}) {
    const auto [frames, report] = cleaned(with_leap(rig, {.leaping = 25, .factor = factor}), rig);
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_EQ(frames[k].observations.size(), 30u);
      EXPECT_EQ(matched_in(frames[k]).size(), k < 2 ? 30u : 5u) << factor;
    }
    EXPECT_EQ(report.leapt_matches, 25u);
    EXPECT_EQ(report.rig_jumps, 0u);
    EXPECT_THAT(in_words(report), ElementsAre(HasSubstr("the right pixels of 25 points leap")));
  }
}

/// Half a second later nobody knows what depth they should have.
TEST(FrameCleaner, TakesMatchesBackThatReturnSoon) {
  const StereoCalibration rig = rig_of(0.5);
  for (const auto& [back, matched] : {std::pair{4u, 30u}, {16u, 5u}}) {
    const Leap leap{.leaping = 25, .factor = 2.1, .back = back, .count = back + 3};
    const Frames frames = cleaned(with_leap(rig, leap), rig).frames;
    EXPECT_EQ(matched_in(frames[back - 1]).size(), 5u);
    for (std::size_t k = back; k < frames.size(); ++k) {
      EXPECT_EQ(matched_in(frames[k]).size(), matched) << k;
    }
  }
}

/// Each frame anew a third of the matches is wrong: most of two frames' points differ, and none of them leapt
/// to stay.
TEST(FrameCleaner, LeavesMismatchesAloneThatEachFrameDrawsAnew) {
  const StereoCalibration rig = rig_of(0.5);
  Frames frames = with_leap(rig, {.count = 60});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0.0, 1.0), u(5.0, 600.0), v(5.0, 400.0);
  std::size_t wrong = 0;
  for (StereoFrame& frame : frames) {
    for (StereoObservation& point : frame.observations) {
      if (share(random) < 0.33) {
        point.uv_cam1 = {u(random), v(random)};
        ++wrong;
      }
    }
  }
  const Cleaned out = cleaned(frames, rig);
  std::size_t left_out = 0;
  for (const StereoFrame& frame : out.frames) {
    left_out += 30 - matched_in(frame).size();
  }
  EXPECT_LT(left_out, wrong / 5);
}

/// Also when the disparity of all points doubles: no rig does that without moving by half its baseline.
TEST(FrameCleaner, EndsMatchesOfAFrameWhoseDisparityDoubles) {
  const StereoCalibration rig = rig_of(0.5);
  const Cleaned out = cleaned(with_leap(rig, {.leaping = 30, .factor = 2.0}), rig);
  EXPECT_TRUE(matched_in(out.frames[2]).empty());
}

/// A shock of half a degree in vergence moves the parallax of far points by more than their own size where
/// the baseline is short. What the rig does is for the monitor to see.
TEST(FrameCleaner, NeverRemovesWhatAJumpOfTheRigExplains) {
  for (const double baseline : {0.12, 0.5}) {
    const StereoCalibration rig = rig_of(baseline);
    for (const double degrees : {0.5, -0.5, 1.0, 3.0}) {
      Leap leap;
      leap.jump(1) = degrees * M_PI / 180.0;
      leap.jump(0) = 0.2 * M_PI / 180.0;
      leap.jump(4) = 0.01 * baseline;
      const Frames frames = with_leap(rig, leap);
      const Cleaned out = cleaned(frames, rig);
      for (const StereoFrame& frame : out.frames) {
        EXPECT_EQ(matched_in(frame).size(), 30u) << baseline << " m, " << degrees << " deg";
      }
      EXPECT_EQ(out.report.leapt_matches, 0u);
      // Half a degree makes most points leap in one direction only: in the other their parallax changes sign.
      if (baseline < 0.2 && std::abs(degrees) >= 1.0) {
        EXPECT_EQ(out.report.rig_jumps, 1u) << degrees;
        EXPECT_THAT(in_words(out.report), ElementsAre(HasSubstr("one jump of the rig")));
      }
    }
  }
}

/// From a quarter too short to a quarter too long and back, as the paper's square wave has it.
TEST(FrameCleaner, NeverRemovesWhatABaselineThatJumpsByAQuarterEitherWayExplains) {
  const StereoCalibration assumed = rig_of(0.5);
  for (const double before : {0.75, 1.25}) {
    Leap leap;
    leap.jump(3) = -(2.0 - 2.0 * before) * 0.5;
    const Cleaned out = cleaned(with_leap(rig_of(0.5 * before), leap), assumed);
    EXPECT_EQ(out.report.leapt_matches, 0u) << before;
  }
}

Frames with_noise(Frames frames, double sigma_px, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0.0, sigma_px);
  for (StereoFrame& frame : frames) {
    for (StereoObservation& point : frame.observations) {
      for (Vector2d* const uv : {&point.uv_cam0, &point.uv_cam1}) {
        const double du = noise(generator), dv = noise(generator);
        *uv += Vector2d(du, dv);
      }
    }
  }
  return frames;
}

/// White noise in both images: a jump has to fit as well as frames between which nothing jumps do, no better.
TEST(FrameCleaner, NeverRemovesWhatAJumpOfTheRigExplainsAmongNoisyPixels) {
  const StereoCalibration rig = rig_of(0.12);
  Leap leap;
  leap.jump(1) = 2.0 * M_PI / 180.0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Frames frames = with_noise(with_leap(rig, leap), 1.0, seed);
    const Cleaned out = cleaned(frames, rig);
    EXPECT_EQ(out.report.leapt_matches, 0u) << seed;
    EXPECT_EQ(out.report.rig_jumps, 1u) << seed;
    // Noise does not hide matches that leap to something else: 25 points exchange their right pixels.
    for (std::size_t k = 2; k < frames.size(); ++k) {
      const StereoFrame right = frames[k];
      for (std::size_t i = 0; i < 25; ++i) {
        frames[k].observations[i].uv_cam1 = right.observations[(i + 7) % 25].uv_cam1;
      }
    }
    EXPECT_GE(cleaned(frames, rig).report.leapt_matches, 20u) << seed;
  }
}

/// Few at once are left to the gate, and after a gap of a second anything may have come near.
TEST(FrameCleaner, LeavesMatchesAloneThatMayHaveLeaptForAReason) {
  const StereoCalibration rig = rig_of(0.5);
  for (const Leap& leap :
       {Leap{.leaping = 12, .factor = 2.1}, Leap{.leaping = 25, .factor = 2.1, .step_ns = 1'000'000'000}}) {
    for (const StereoFrame& frame : cleaned(with_leap(rig, leap), rig).frames) {
      EXPECT_EQ(matched_in(frame).size(), 30u);
    }
  }
}

TEST(FrameCleaner, LeavesEverythingAloneWhenItIsOff) {
  const StereoCalibration rig = rig_of(0.5);
  const auto [frames, report] =
      cleaned(with_leap(rig, {.leaping = 25, .factor = 2.1}), rig, {.clean = false});
  EXPECT_EQ(matched_in(frames[3]).size(), 30u);
  EXPECT_TRUE(in_words(report).empty());
}

/// A dense cluster in a corner, and a few points elsewhere.
Frames crowded(std::size_t count) {
  Frames frames;
  for (std::int64_t k = 0; k < 3; ++k) {
    StereoFrame frame{k * kStepNs, {}};
    for (std::size_t n = static_cast<std::size_t>(3 * k); n < count + static_cast<std::size_t>(3 * k); ++n) {
      const double a = static_cast<double>(n % 97) / 97.0, b = static_cast<double>(n % 89) / 89.0;
      const bool scattered = n % 50 == 0;
      const Vector2d uv = scattered ? Vector2d(640.0 * a, 480.0 * b) : Vector2d(60.0 * a, 60.0 * b);
      frame.observations.push_back({static_cast<std::int64_t>(n), uv, uv, true, n % 3 != 0});
    }
    frames.push_back(frame);
  }
  return frames;
}

TEST(FrameCleaner, ThinsCrowdedFramesEvenlyAndKeepsTracks) {
  const Frames frames = crowded(2000);
  const auto [out, report] = cleaned(frames, rig_of(0.5), {.clean = true, .max_points = 100});
  for (const StereoFrame& frame : out) {
    EXPECT_EQ(frame.observations.size(), 100u);
    std::size_t in_corner = 0;
    for (const StereoObservation& point : frame.observations) {
      in_corner += point.uv_cam0.x() < 80.0 && point.uv_cam0.y() < 80.0 ? 1 : 0;
    }
    EXPECT_LT(in_corner, 75u) << "98 % of the points given are there";
  }
  const Tracks first = tracks_of(out[0]), second = tracks_of(out[1]);
  const auto common = std::count_if(first.begin(), first.end(), [&](std::int64_t id) {
    return std::find(second.begin(), second.end(), id) != second.end();
  });
  EXPECT_GE(common, 97) << "all that the front end still has";
  EXPECT_EQ(report.thinned_frames, 3u);
  EXPECT_EQ(report.thinned_points, 3u * 1900u);
  EXPECT_THAT(in_words(report), ElementsAre(HasSubstr("--max-points")));
}

TEST(FrameCleaner, LeavesFramesOfUsualSizeAsTheyAre) {
  const Frames frames = crowded(500);
  const Frames out = cleaned(frames, rig_of(0.5)).frames;
  ASSERT_EQ(out.size(), frames.size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    EXPECT_EQ(tracks_of(out[k]), tracks_of(frames[k]));
  }
}

/// The points of the first frame stand at twice their disparity from the second frame on.
TEST(FrameCleaner, EndsTheMatchesThatLeapInKittiTrackLogs) {
  struct Drive {
    const char* name;
    std::size_t in_first_frame, leap;
  };
  for (const Drive& drive : {Drive{"track_logs/kitti_09_26_drive_0001", 48, 47},
                             Drive{"track_logs/kitti_09_26_drive_0005", 58, 58},
                             Drive{"track_logs/kitti_09_26_drive_0036", 18, 18},
                             Drive{"track_logs/kitti_09_26_drive_0095", 85, 85}}) {
    LIMBER_NEED_DATA(folder, drive.name);
    const Recording r = read_recording(folder);
    const Cleaned out = cleaned({r.frames[0], r.frames[1]}, r.calibration);
    EXPECT_EQ(matched_in(r.frames[0]).size(), drive.in_first_frame) << drive.name;
    EXPECT_EQ(matched_in(out.frames[0]).size(), drive.in_first_frame) << drive.name;
    EXPECT_EQ(matched_in(out.frames[1]).size(), drive.in_first_frame - drive.leap) << drive.name;
    EXPECT_EQ(out.frames[1].observations.size(), drive.in_first_frame) << drive.name;
  }
}

/// In 91 of its 1106 frames old pixels are handed out once more.
TEST(FrameCleaner, EndsTheStaleTracksOfAKittiTrackLog) {
  LIMBER_NEED_DATA(folder, "track_logs/kitti_09_30_drive_0027");
  const Recording r = read_recording(folder);
  EXPECT_EQ(cleaned(r.frames, r.calibration).report.stale_frames, 91u);
}

}  // namespace
}  // namespace limber
