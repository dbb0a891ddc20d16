// SPDX-License-Identifier: MIT
// Rows that are exposed one after the other: points go to where they were at the stamp.
#include <gtest/gtest.h>

#include <vector>

#include "limber/clean/frame_cleaner.hpp"

namespace limber {
namespace {

using Eigen::Vector2d;

constexpr double kReadout = 0.03;
constexpr std::int64_t kFrameNs = 50'000'000;

StereoCalibration rig_with_readout(double cam0_s, double cam1_s) {
  StereoCalibration rig;
  rig.cam0 = rig.cam1 = {500.0, 500.0, 320.0, 240.0, 640, 480, NoDistortion{}};
  rig.theta(3) = -0.1;
  rig.readout_time_s = {cam0_s, cam1_s};
  return rig;
}

/// A point that is thrown across the image.
Vector2d thrown(double t) { return {100.0 + 300.0 * t - 900.0 * t * t, 400.0 - 500.0 * t + 700.0 * t * t}; }

/// Where a camera that takes `readout` sees it: the row says when, and when says the row.
Vector2d seen_by_row(double stamp_s, double readout) {
  Vector2d uv = thrown(stamp_s);
  for (int k = 0; k < 50; ++k) {
    uv = thrown(stamp_s + (uv.y() / 480.0 - 0.5) * readout);
  }
  return uv;
}

StereoFrame frame_of(int n, double readout0, double readout1, bool in_cam1 = true) {
  const double t = 1e-9 * static_cast<double>(n * kFrameNs);
  StereoFrame out{n * kFrameNs, {}};
  out.observations.push_back(
      {7, seen_by_row(t, readout0), seen_by_row(t, readout1) - Vector2d(20.0, 0.0), true, in_cam1});
  return out;
}

TEST(RowTimes, MoveAPointToWhereItWasAtTheStamp) {
  FrameCleaner cleaner(rig_with_readout(kReadout, -kReadout), {});
  for (int n = 0; n < 8; ++n) {
    const double t = 1e-9 * static_cast<double>(n * kFrameNs);
    const StereoFrame given = frame_of(n, kReadout, -kReadout);
    const StereoFrame referred = cleaner.clean(given);
    if (n == 0) {
      EXPECT_TRUE(referred.observations.empty()) << "nobody knows how it moves";
      continue;
    }
    ASSERT_EQ(referred.observations.size(), 1U);
    const StereoObservation& o = referred.observations[0];
    // Two views make a line, three the parabola.
    const double near = n == 1 ? 2.0 : 1e-6;
    EXPECT_LT((o.uv_cam0 - thrown(t)).norm(), near) << n;
    EXPECT_LT((o.uv_cam1 + Vector2d(20.0, 0.0) - thrown(t)).norm(), near) << n;
  }
  EXPECT_EQ(cleaner.report().waiting_points, 1U);
  EXPECT_GT((frame_of(0, kReadout, 0.0).observations[0].uv_cam0 - thrown(0.0)).norm(), 5.0);
}

TEST(RowTimes, GiveANewRightPixelTheMotionOfTheLeftOne) {
  FrameCleaner cleaner(rig_with_readout(kReadout, kReadout), {});
  for (int n = 0; n < 4; ++n) {
    (void)cleaner.clean(frame_of(n, kReadout, kReadout, false));
  }
  const StereoFrame referred = cleaner.clean(frame_of(4, kReadout, kReadout));
  ASSERT_EQ(referred.observations.size(), 1U);
  EXPECT_LT((referred.observations[0].uv_cam1 + Vector2d(20.0, 0.0) - thrown(0.2)).norm(), 1e-6);
}

TEST(RowTimes, BeginAnewAfterAGap) {
  FrameCleaner cleaner(rig_with_readout(kReadout, kReadout), {});
  (void)cleaner.clean(frame_of(0, kReadout, kReadout));
  EXPECT_TRUE(cleaner.clean(frame_of(8, kReadout, kReadout)).observations.empty());
  EXPECT_EQ(cleaner.clean(frame_of(9, kReadout, kReadout)).observations.size(), 1U);
}

TEST(RowTimes, ChangeNothingWhereAllRowsAreExposedAtOnceOrFramesAreAtTheirStamps) {
  FrameCleaner global(rig_with_readout(0.0, 0.0), {});
  CleaningOptions done;
  done.refer_to_stamp = false;
  FrameCleaner referred(rig_with_readout(kReadout, kReadout), done);
  for (int n = 0; n < 3; ++n) {
    const StereoFrame given = frame_of(n, kReadout, kReadout);
    for (FrameCleaner* cleaner : {&global, &referred}) {
      const StereoFrame out = cleaner->clean(given);
      ASSERT_EQ(out.observations.size(), 1U);
      EXPECT_EQ(out.observations[0].uv_cam0, given.observations[0].uv_cam0);
    }
  }
}

}  // namespace
}  // namespace limber
