// SPDX-License-Identifier: MIT
#include "limber/landmarks/bearing_walk.hpp"

#include <gtest/gtest.h>

#include "landmarks/pinhole_at_the_body.hpp"
#include "state/small_map.hpp"

namespace limber {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::Generator;

constexpr BearingWalk kWalk{0.01, 10.0};

/// What the left camera sees of these tracks.
StereoFrame frame_of(const std::vector<std::int64_t>& ids) {
  StereoFrame out;
  for (const std::int64_t id : ids) {
    out.observations.push_back({id, {}, {}, true, false});
  }
  return out;
}

/// What a walk adds to the covariance of a landmark's only triplet.
Matrix3d added(Estimate& estimate) {
  Landmark& landmark = *estimate.find(1);
  landmark.sightings = 10;
  const Matrix3d before = estimate.P().diagonal_block<3>(landmark.at);
  walk_bearings(estimate, frame_of({1}), testing::pinhole_at_the_body(), kWalk);
  return estimate.P().diagonal_block<3>(landmark.at) - before;
}

/// Of a landmark on the camera's axis: its pixel walks by the focal length times the angle.
void expect_pixel_to_walk(const Estimate& estimate, const Matrix3d& Q) {
  const Landmark& landmark = *estimate.find(1);
  const auto pixel =
      project_point(testing::pinhole_at_the_body(),
                    body_point(estimate.nav().T_world_body, landmark, estimate.anchor_of(landmark)));
  ASSERT_TRUE(pixel);
  const Matrix2d walked = pixel->J_landmark * Q * pixel->J_landmark.transpose();
  EXPECT_TRUE(walked.isApprox(Matrix2d::Identity(), 1e-6)) << walked;  // (100 px * 0.01)^2
}

TEST(BearingWalk, MovesThePixelOfAnInverseDepthAsSeenFromHere) {
  Estimate estimate = testing::empty_map();
  testing::add_landmark_ahead(estimate, 1, 5.0, 0.01, 0);
  testing::move_body(estimate, [](NavigationState& nav) { nav.T_world_body.p.z() = 3.0; });
  const Matrix3d Q = added(estimate);
  expect_pixel_to_walk(estimate, Q);
  EXPECT_TRUE(Q.col(2).isZero(1e-12));
}

TEST(BearingWalk, MovesThePixelOfACartesianPointAndNotItsDistance) {
  Generator generator(3);
  Estimate estimate = testing::empty_map();
  const Pose T_world_body = testing::random_pose(generator, 5.0);
  testing::move_body(estimate, [&](NavigationState& nav) { nav.T_world_body = T_world_body; });
  Landmark landmark;
  landmark.track_id = 1;
  landmark.kind = LandmarkKind::kCartesian;
  landmark.value = T_world_body * Vector3d(0.0, 0.0, 4.0);
  estimate.add_landmark(landmark, 1e-4 * Matrix3d::Identity());
  const Matrix3d Q = added(estimate);
  expect_pixel_to_walk(estimate, Q);
  EXPECT_TRUE((Q * T_world_body.R.col(2)).isZero(1e-12));
}

TEST(BearingWalk, IsOfThoseThatTheLeftCameraSeesAndHasSeenOften) {
  Generator generator(4);
  Estimate estimate = testing::random_map(generator, 8);
  for (Landmark& landmark : estimate.landmarks()) {
    landmark.sightings = landmark.track_id == 1 ? 9 : 10;
  }
  StereoFrame frame = frame_of({0, 1, 2, 3, 99});
  frame.observations[2].in_cam0 = false;
  frame.observations[2].in_cam1 = true;
  MatrixXd expected = estimate.P().dense();
  walk_bearings(estimate, frame, testing::pinhole_at_the_body(), kWalk);
  const MatrixXd after = estimate.P().dense();
  for (const std::int64_t id : {0, 3}) {
    const Eigen::Index at = estimate.find(id)->at;
    EXPECT_GT((after - expected).block(at, at, 3, 3).trace(), 0.0) << id;
    expected.block(at, at, 3, 3) = after.block(at, at, 3, 3);
  }
  EXPECT_EQ(after, expected);
}

}  // namespace
}  // namespace limber
