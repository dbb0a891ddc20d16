// SPDX-License-Identifier: MIT
#include "limber/state/estimate.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "check_covariance.hpp"
#include "limber/core/so3.hpp"
#include "message_of.hpp"
#include "small_map.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::add_random_landmark;
using testing::Generator;
using testing::random_estimate;
using testing::random_map;
using testing::Snapshot;
using testing::snapshot;

constexpr StateLayout kWithTheta{MotionModel::kConstantVelocity, true};

bool is_positive_definite(const Estimate& estimate) { return Cholesky(estimate.P().dense()).succeeded(); }

TEST(Estimate, StartsWithBodyAndThetaUncorrelated) {
  Generator generator(1);
  const Estimate without = random_estimate(generator);
  EXPECT_EQ(without.size(), 15);
  const Estimate with = random_estimate(generator, kWithTheta);
  EXPECT_EQ(with.size(), 12 + 6);
  EXPECT_TRUE(with.P().block(0, 12, 12, 6).isZero(0.0));
  EXPECT_TRUE(is_positive_definite(with));
}

TEST(Estimate, RefusesACovarianceOfAnotherMotionModelAndSaysBothSizes) {
  const std::string message = testing::message_of([] {
    const Estimate estimate({MotionModel::kImu, false}, {}, MatrixXd::Identity(12, 12), {}, {});
  });
  EXPECT_NE(message.find("12x12"), std::string::npos) << message;
  EXPECT_NE(message.find("15"), std::string::npos) << message;
}

TEST(Estimate, InsertingThenRemovingALandmarkChangesNothingElse) {
  Generator generator(2);
  for (const int count : {0, 1, 5, 14}) {
    Estimate estimate = random_map(generator, count);
    const Snapshot before = snapshot(estimate);
    const Index size = estimate.size();
    add_random_landmark(generator, estimate, 1000, -1);
    const int anchor = estimate.add_anchor({});
    add_random_landmark(generator, estimate, 1001, anchor);
    EXPECT_EQ(snapshot(estimate, {1000, 1001}), before) << count;
    estimate.remove_landmark(1000);
    estimate.remove_landmark(1001);
    EXPECT_EQ(snapshot(estimate), before) << count;
    EXPECT_EQ(estimate.size(), size) << count;
  }
}

TEST(Estimate, RemovalChangesNothingElseInAnyOrder) {
  Generator generator(3);
  const Estimate full = random_map(generator, 12);
  std::vector<std::int64_t> gone = {0, 3, 4, 5, 6, 11};
  const Snapshot expected = snapshot(full, gone);
  for (int k = 0; k < 50; ++k) {
    std::shuffle(gone.begin(), gone.end(), generator);
    Estimate estimate = full;
    for (const std::int64_t track_id : gone) {
      estimate.remove_landmark(track_id);
      EXPECT_EQ(estimate.find(track_id), nullptr);
    }
    EXPECT_EQ(snapshot(estimate), expected);
  }
}

TEST(Estimate, RemovingAnUnknownLandmarkChangesNothing) {
  Generator generator(4);
  Estimate estimate = random_map(generator, 5);
  const Snapshot before = snapshot(estimate);
  estimate.remove_landmark(77);
  EXPECT_EQ(snapshot(estimate), before);
}

TEST(Estimate, AnAnchorLeavesWithItsLastLandmark) {
  Generator generator(5);
  Estimate estimate = random_estimate(generator);
  const int anchor = estimate.add_anchor({});
  EXPECT_EQ(estimate.size(), 15 + 6);
  add_random_landmark(generator, estimate, 1, anchor);
  add_random_landmark(generator, estimate, 2, anchor);
  estimate.remove_landmark(1);
  EXPECT_EQ(estimate.size(), 15 + 6 + 3);
  estimate.remove_landmark(2);
  EXPECT_EQ(estimate.size(), 15);
}

TEST(Estimate, AnAnchorThatNobodyStandsOnCanBeDropped) {
  Generator generator(6);
  Estimate estimate = random_map(generator, 6);
  const Snapshot before = snapshot(estimate);
  const Index size = estimate.size();
  const int anchor = estimate.add_anchor({});
  estimate.drop_unused_anchor(anchor);
  EXPECT_EQ(estimate.size(), size);
  EXPECT_EQ(snapshot(estimate), before);
  const int used = estimate.landmarks().front().anchor;
  estimate.drop_unused_anchor(used);
  estimate.drop_unused_anchor(-1);
  EXPECT_EQ(estimate.size(), size);
}

TEST(Estimate, ManyLandmarksThatComeAndGoLeaveNoTrace) {
  Generator generator(7);
  Estimate estimate = random_map(generator, 6, kWithTheta);
  const Snapshot before = snapshot(estimate);
  const Index size = estimate.size();
  std::vector<std::int64_t> alive;
  for (std::int64_t id = 100; id < 300; ++id) {
    const int anchor = id % 3 == 0 ? -1 : estimate.add_anchor({});
    add_random_landmark(generator, estimate, id, anchor);
    alive.push_back(id);
    std::shuffle(alive.begin(), alive.end(), generator);
    while (alive.size() > 8) {
      estimate.remove_landmark(alive.back());
      alive.pop_back();
    }
    ASSERT_EQ(snapshot(estimate, alive), before) << id;
    ASSERT_TRUE(is_positive_definite(estimate)) << id;
  }
  for (const std::int64_t id : alive) {
    estimate.remove_landmark(id);
  }
  EXPECT_EQ(estimate.size(), size);
  EXPECT_EQ(snapshot(estimate), before);
}

TEST(Estimate, EveryTripletBelongsToOneTenant) {
  Generator generator(8);
  Estimate estimate = random_map(generator, 11);
  for (const std::int64_t id : {3, 0, 7, 10}) {
    estimate.remove_landmark(id);
  }
  std::vector<Index> places;
  std::vector<int> anchors;
  for (const Landmark& landmark : estimate.landmarks()) {
    EXPECT_EQ(estimate.find(landmark.track_id), &landmark);
    places.push_back(landmark.at);
    if (landmark.anchor >= 0 && std::find(anchors.begin(), anchors.end(), landmark.anchor) == anchors.end()) {
      anchors.push_back(landmark.anchor);
      places.push_back(estimate.anchor_of(landmark)->position_at);
      places.push_back(estimate.anchor_of(landmark)->attitude_at);
    }
  }
  std::sort(places.begin(), places.end());
  Index expected = estimate.layout().map_begin();
  for (const Index place : places) {
    EXPECT_EQ(place, expected);
    expected += kTriplet;
  }
  EXPECT_EQ(expected, estimate.size());
}

TEST(Estimate, ACloneKnowsWhatThePoseKnows) {
  Generator generator(9);
  Estimate estimate = random_map(generator, 4);
  const Index at = estimate.size();
  const MatrixXd before = estimate.P().dense();
  const Pose T_body_cam0 = testing::random_pose(generator, 0.1);
  add_random_landmark(generator, estimate, 50, estimate.add_anchor(T_body_cam0));
  const Anchor& anchor = *estimate.anchor_of(*estimate.find(50));
  EXPECT_EQ(anchor.T_world_body.R, estimate.nav().T_world_body.R);
  EXPECT_EQ(anchor.T_world_body.p, estimate.nav().T_world_body.p);
  EXPECT_EQ(anchor.T_body_cam0.R, T_body_cam0.R);
  EXPECT_EQ(anchor.position_at, at);
  EXPECT_EQ(anchor.attitude_at, at + 3);
  const MatrixXd after = estimate.P().dense();
  EXPECT_EQ(after.topLeftCorner(at, at), before);
  EXPECT_EQ(MatrixXd(after.block(at, 0, 6, at)), MatrixXd(before.topRows(6)));
  EXPECT_LE((after.block<6, 6>(at, at) - before.topLeftCorner<6, 6>()).cwiseAbs().maxCoeff(), 1.1e-12);
  EXPECT_TRUE(is_positive_definite(estimate));
}

TEST(Estimate, ClonesOfClonesStayPositiveDefinite) {
  Generator generator(10);
  Estimate estimate = random_estimate(generator);
  for (int k = 0; k < 20; ++k) {
    add_random_landmark(generator, estimate, k, estimate.add_anchor({}));
  }
  EXPECT_TRUE(is_positive_definite(estimate));
}

TEST(Estimate, RetractionMovesEveryPartByItsOwnTriplets) {
  Generator generator(11);
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    for (const bool has_theta : {false, true}) {
      const StateLayout layout{motion, has_theta};
      const Estimate before = random_map(generator, 7, layout);
      Estimate after = before;
      const VectorXd dx = 0.01 * testing::random_normal(generator, before.size());
      after.retract(dx);
      const Vector3d turn = before.nav().T_world_body.R * dx.segment<3>(3);
      const auto turned = [&](Index at) {  // world vectors turn with the body
        return Vector3d(so3_right_jacobian(-turn) * dx.segment<3>(at));
      };
      const auto expect_moved = [&](const Pose& from, const Pose& to, Index position, Index attitude) {
        EXPECT_LE((to.p - from.p - turned(position)).norm(), 1e-14);
        EXPECT_LE((so3_log(from.R.transpose() * to.R) - dx.segment<3>(attitude)).norm(), 1e-14);
      };
      expect_moved(before.nav().T_world_body, after.nav().T_world_body, 0, 3);
      const Vector3d dv = after.nav().v_world_body - before.nav().v_world_body;
      const Vector3d dw = after.nav().omega_body - before.nav().omega_body;
      const Vector3d dbg = after.nav().bias_gyro - before.nav().bias_gyro;
      const Vector3d dba = after.nav().bias_accel - before.nav().bias_accel;
      const bool imu = motion == MotionModel::kImu;
      const bool constant_velocity = motion == MotionModel::kConstantVelocity;
      EXPECT_LE((dv - (imu || constant_velocity ? turned(6) : Vector3d::Zero())).norm(), 1e-14);
      EXPECT_LE((dw - (constant_velocity ? Vector3d(dx.segment<3>(9)) : Vector3d::Zero())).norm(), 1e-14);
      EXPECT_LE((dbg - (imu ? Vector3d(dx.segment<3>(9)) : Vector3d::Zero())).norm(), 1e-14);
      EXPECT_LE((dba - (imu ? Vector3d(dx.segment<3>(12)) : Vector3d::Zero())).norm(), 1e-14);
      const RigParameters dtheta = after.theta() - before.theta();
      EXPECT_LE((dtheta - (has_theta ? RigParameters(dx.segment<6>(layout.theta())) : RigParameters::Zero()))
                    .norm(),
                1e-14);
      for (const Landmark& landmark : before.landmarks()) {
        const Landmark& moved = *after.find(landmark.track_id);
        const bool is_cartesian = landmark.kind == LandmarkKind::kCartesian;
        const Vector3d by = is_cartesian ? turned(landmark.at) : Vector3d(dx.segment<3>(landmark.at));
        EXPECT_LE((moved.value - landmark.value - by).norm(), 1e-14);
        if (const Anchor* anchor = before.anchor_of(landmark); anchor != nullptr) {
          expect_moved(anchor->T_world_body, after.anchor_of(moved)->T_world_body, anchor->position_at,
                       anchor->attitude_at);
        }
      }
    }
  }
}

TEST(Estimate, AMountThatShrinksScalesItsMeanItsRowsAndItsColumns) {
  Generator generator(12);
  StateLayout layout{MotionModel::kOdometry, true};
  layout.has_more.back() = true;
  Estimate estimate = random_map(generator, 7, layout);
  estimate.retract(0.01 * testing::random_normal(generator, estimate.size()));
  const MatrixXd before = estimate.P().dense();
  const auto mean = estimate.more();
  MatrixXd M = MatrixXd::Identity(estimate.size(), estimate.size());
  M.diagonal().segment<3>(layout.more(2)).setConstant(0.7);
  estimate.shrink_mount_rotation(0.7);
  EXPECT_LE((estimate.P().dense() - M * before * M.transpose()).norm(), 1e-14 * before.norm());
  EXPECT_LE((estimate.more().segment<3>(12) - 0.7 * mean.segment<3>(12)).norm(), 1e-17);
  EXPECT_EQ(estimate.more().head<12>(), mean.head<12>());
  EXPECT_EQ(estimate.more().tail<3>(), mean.tail<3>());
}

TEST(Estimate, MovesWithTheScaleOfOdometry) {
  Generator generator(16);
  StateLayout layout{MotionModel::kOdometry};
  layout.has_map_scale = layout.has_odometry_scale = true;
  Estimate estimate = random_map(generator, 7, layout);
  const Eigen::Index n = estimate.size(), at = layout.odometry_scale();
  const MatrixXd P = estimate.P().dense();
  const Eigen::Vector3d way = testing::random_normal(generator, 3);
  estimate.move_with_odometry_scale(way);
  MatrixXd moved = MatrixXd::Identity(n, n);
  moved.block<3, 1>(StateLayout::kPosition, at) = way;
  EXPECT_LE((estimate.P().dense() - moved * P * moved.transpose()).norm(), 1e-12 * P.norm());
}

/// The gain of an update without what it would do to one of the states, and to all that moves with it.
TEST(Estimate, AScaleThatIsHeldStaysWhatItWasAndAllElseHasTheBestGain) {
  Generator generator(15);
  StateLayout layout;
  layout.has_map_scale = true;
  Estimate estimate = random_map(generator, 7, layout);
  const Eigen::Index n = estimate.size(), at = layout.map_scale();
  const MatrixXd P = estimate.P().dense();
  const MatrixXd H = testing::random_normal(generator, 5 * n).reshaped(5, n);
  const Eigen::VectorXd residual = testing::random_normal(generator, 5);
  const MatrixXd S = H * P * H.transpose() + MatrixXd::Identity(5, 5);
  const MatrixXd K = P * H.transpose() * S.inverse();
  const Estimate::Considered before = estimate.considered(at);
  estimate.mutable_P().assign(P - K * S * K.transpose());
  Eigen::VectorXd dx = K * residual;
  estimate.hold(before, dx);

  MatrixXd held = K;
  held -= P.col(at) / P(at, at) * K.row(at);
  const MatrixXd left = MatrixXd::Identity(n, n) - held * H;
  const MatrixXd expected = left * P * left.transpose() + held * held.transpose();
  EXPECT_LE((estimate.P().dense() - expected).norm(), 1e-10 * P.norm());
  EXPECT_LE((dx - held * residual).norm(), 1e-10 * dx.norm());
  EXPECT_NEAR(dx(at), 0.0, 1e-12);
  EXPECT_NEAR(estimate.P().dense()(at, at), P(at, at), 1e-10 * P(at, at));
}

TEST(Estimate, ConversionKeepsPositionCovarianceAndCorrelations) {
  Generator generator(12);
  Estimate estimate = random_map(generator, 10);
  for (const std::int64_t id : {0, 1, 4, 2, 9}) {
    Landmark& landmark = *estimate.find(id);
    Matrix3d P_before;
    const Vector3d before = estimate.landmark_position(landmark, &P_before);
    // Correlation with the body: the Jacobian of the position times what its sources know of it.
    const Anchor anchor = *estimate.anchor_of(landmark);
    const Eigen::Matrix<double, 3, 9> J = world_position_jacobian(landmark, anchor);
    MatrixXd sources(9, 15);
    sources << estimate.P().block(anchor.position_at, 0, 3, 15),
        estimate.P().block(anchor.attitude_at, 0, 3, 15), estimate.P().block(landmark.at, 0, 3, 15);
    const Snapshot others = snapshot(estimate, {id});
    estimate.convert_to_cartesian(landmark);

    const Landmark& converted = *estimate.find(id);
    EXPECT_EQ(converted.kind, LandmarkKind::kCartesian);
    EXPECT_EQ(estimate.anchor_of(converted), nullptr);
    Matrix3d P_after;
    EXPECT_LE((estimate.landmark_position(converted, &P_after) - before).norm(), 1e-13);
    EXPECT_LE((P_after - P_before).norm(), 1e-13 * P_before.norm());
    EXPECT_LE((estimate.P().block(converted.at, 0, 3, 15) - J * sources).norm(), 1e-13 * sources.norm());
    EXPECT_EQ(snapshot(estimate, {id}), others);
  }
}

TEST(Estimate, ConversionReleasesTheAnchor) {
  Generator generator(13);
  Estimate estimate = random_estimate(generator);
  const int anchor = estimate.add_anchor({});
  add_random_landmark(generator, estimate, 1, anchor);
  add_random_landmark(generator, estimate, 2, anchor);
  estimate.convert_to_cartesian(*estimate.find(1));
  EXPECT_EQ(estimate.size(), 15 + 6 + 6);
  estimate.convert_to_cartesian(*estimate.find(2));
  EXPECT_EQ(estimate.size(), 15 + 6);
  EXPECT_TRUE(is_positive_definite(estimate));
}

TEST(Estimate, LandmarkCovarianceIsThatOfManyDraws) {
  Generator generator(14);
  Estimate estimate = random_estimate(generator);
  const int index = estimate.add_anchor(testing::random_pose(generator, 0.1));
  add_random_landmark(generator, estimate, 1, index);
  const Landmark& landmark = *estimate.find(1);
  const Anchor& anchor = *estimate.anchor_of(landmark);
  // Shrunk, so that the map from landmark to position is nearly linear.
  const double shrink = 0.02;
  Matrix3d P;
  const Vector3d mean = estimate.landmark_position(landmark, &P);
  std::vector<Index> places;
  for (const Index start : {anchor.position_at, anchor.attitude_at, landmark.at}) {
    for (Index k = 0; k < 3; ++k) {
      places.push_back(start + k);
    }
  }
  const MatrixXd root = Cholesky(estimate.P().dense()(places, places)).L();
  testing::SampleCovariance errors(3);
  for (int k = 0; k < 20000; ++k) {
    const VectorXd d = shrink * root * testing::random_normal(generator, 9);
    Anchor moved_anchor = anchor;
    moved_anchor.T_world_body.p += d.segment<3>(0);
    moved_anchor.T_world_body.R *= so3_exp(d.segment<3>(3));
    Landmark moved = landmark;
    moved.value += d.segment<3>(6);
    errors.add(world_position(moved, &moved_anchor) - mean);
  }
  errors.expect(shrink * shrink * P, 0.01);
}

}  // namespace
}  // namespace limber
