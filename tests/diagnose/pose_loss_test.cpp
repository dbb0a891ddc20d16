// SPDX-License-Identifier: MIT
#include "limber/diagnose/pose_loss.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace limber {
namespace {

std::vector<StampedPose> straight(double step, double start, std::size_t n) {
  std::vector<StampedPose> out;
  for (std::size_t k = 0; k < n; ++k) {
    Pose pose;
    pose.p = Eigen::Vector3d(start + step * static_cast<double>(k), 0.0, 0.0);
    out.push_back({static_cast<std::int64_t>(k) * 100'000'000, pose});
  }
  return out;
}

TEST(PoseLoss, IsScaleAndDriftByDistance) {
  const auto loss = pose_loss(straight(1.02, 7.0, 51), straight(1.0, 0.0, 51));
  ASSERT_TRUE(loss);
  EXPECT_NEAR(loss->path_m, 50.0, 1e-9);
  EXPECT_NEAR(loss->scale, 1.02, 1e-9);
  EXPECT_NEAR(loss->drift_per_100_m, 2.0, 1e-9);
  EXPECT_NEAR(loss->turn_deg, 0.0, 1e-6);
}

TEST(PoseLoss, OfNoPathIsNothing) {
  EXPECT_FALSE(pose_loss(straight(0.0, 0.0, 51), straight(0.0, 0.0, 51)));
  EXPECT_FALSE(pose_loss(straight(1.0, 0.0, 5), straight(1.0, 0.0, 5)));
}

}  // namespace
}  // namespace limber
