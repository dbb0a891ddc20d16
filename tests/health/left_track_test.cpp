// SPDX-License-Identifier: MIT
#include "limber/health/left_track.hpp"

#include <gtest/gtest.h>

#include "limber/core/so3.hpp"
#include "limber/health/bounded_influence.hpp"

namespace limber::detail {
namespace {

using Eigen::Vector3d;

constexpr double kFocal_px = 458.0;
const Vector3d kPoint(1.0, 0.4, 6.0);

/// A camera that goes sideways and turns, seen without noise.
std::vector<LeftView> views_of(const Vector3d& point) {
  std::vector<LeftView> out;
  for (int n = 0; n < 20; ++n) {
    const double t = 0.05 * n;
    const Pose pose{so3_exp(Vector3d(0.02 * n, -0.01 * n, 0.03)), Vector3d(0.8 * t, 0.1 * t * t, 0.2 * t)};
    const Vector3d ray = pose.R.transpose() * (point - pose.p);
    out.push_back({pose, ray / ray.z()});
  }
  return out;
}

TEST(LeftTrack, IsThePointThatAllViewsSee) {
  const auto found = triangulate(views_of(kPoint), kFocal_px);
  ASSERT_TRUE(found);
  EXPECT_LT((found->in_world - kPoint).norm(), 1e-9);
}

TEST(LeftTrack, LeavesMismatchesOut) {
  std::vector<LeftView> views = views_of(kPoint);
  views[4].d0.x() += 200.0 / kFocal_px;
  views[11].d0 += Vector3d(-30.0, 90.0, 0.0) / kFocal_px;
  views[12].d0.y() += 5.0 / kFocal_px;
  const auto found = triangulate(views, kFocal_px);
  ASSERT_TRUE(found);
  EXPECT_LT((found->in_world - kPoint).norm(), 1e-9);
}

TEST(LeftTrack, OfWhatMovesIsNone) {
  std::vector<LeftView> views = views_of(kPoint);
  for (std::size_t n = 0; n < views.size(); ++n) {
    views[n].d0.y() += 0.002 * static_cast<double>(n * n) / 20.0;
  }
  EXPECT_FALSE(triangulate(views, kFocal_px));
}

TEST(LeverWeights, LeaveARowNoMoreInfluenceThanOneOfFourTimesTheUsualDerivative) {
  Eigen::MatrixXd J(5, 2);
  J << 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 2.0, 0.0, -60.0, 0.0;
  const Eigen::VectorXd weights = lever_weights(J);
  EXPECT_EQ(weights.head(4), Eigen::VectorXd::Ones(4));
  EXPECT_DOUBLE_EQ(weights(4), 1.0 / 225.0);
}

}  // namespace
}  // namespace limber::detail
