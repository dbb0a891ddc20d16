// SPDX-License-Identifier: MIT
// What nobody can observe stays unknown when an estimate is moved: gauge and scale.
#include "limber/core/factors.hpp"
#include "limber/state/estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
using testing::gauge;
using testing::Generator;
using testing::random_estimate;
using testing::random_map;
using testing::Snapshot;
using testing::snapshot;

TEST(Estimate, RetractionKeepsUnknownWhatNobodyCanObserve) {
  Generator generator(15);
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    for (const bool has_theta : {false, true}) {
      Estimate estimate = random_map(generator, 8, {motion, has_theta});
      const Index n = estimate.size();
      const MatrixXd before = gauge(estimate);
      estimate.mutable_P().set_diagonal_block(0,
                                              1e-14 * MatrixXd::Identity(n, n) + before * before.transpose());
      estimate.retract(0.2 * testing::random_normal(generator, n));
      // All it knows is still all but place and heading of the world, as seen from the new estimate.
      const MatrixXd after = gauge(estimate);
      EXPECT_LE((estimate.P().dense() - after * after.transpose()).cwiseAbs().maxCoeff(), 1e-10);
      EXPECT_GT((after - before).cwiseAbs().maxCoeff(), 0.1);
    }
  }
}

TEST(Estimate, RetractionTurnsTheWorldAsAWhole) {
  Generator generator(25);
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    const Estimate before = random_map(generator, 8, {motion, false});
    Estimate after = before;
    const Vector3d turn = 0.3 * testing::random_normal(generator, 3);
    after.retract(gauge(before).leftCols<3>() * turn);
    const auto rounding = [](const Vector3d& x) { return 1e-13 * (1.0 + x.norm()); };
    const Pose &from = before.nav().T_world_body, &to = after.nav().T_world_body;
    EXPECT_LE((to.R - so3_exp(turn) * from.R).norm(), 1e-13);
    EXPECT_LE((to.p - so3_exp(turn) * from.p).norm(), rounding(from.p));
    const Vector3d &v = before.nav().v_world_body, &faster = after.nav().v_world_body;
    if (motion != MotionModel::kOdometry) {
      EXPECT_LE((faster - so3_exp(turn) * v).norm(), rounding(v));
    }
    for (const Landmark& landmark : before.landmarks()) {
      const Vector3d x = before.landmark_position(landmark);
      const Vector3d moved = after.landmark_position(*after.find(landmark.track_id));
      EXPECT_LE((moved - so3_exp(turn) * x).norm(), 10.0 * rounding(x)) << landmark.track_id;
    }
  }
}

/// Derivatives by the errors after a retraction say of the covariance after it what their counterparts say of
/// the one before.
TEST(Estimate, RefersDerivativesBackAsItCarriesTheCovariance) {
  Generator generator(27);
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    for (const bool has_scale : {false, true}) {
      StateLayout layout{motion};
      layout.has_map_scale = has_scale && motion != MotionModel::kOdometry;
      const Estimate before = random_map(generator, 8, layout);
      const Index n = before.size();
      const VectorXd dx = 0.2 * testing::random_normal(generator, n);
      SparseJacobian H;
      for (Index at = 0; at + kTriplet <= n; at += kTriplet) {
        H.blocks.push_back({at % 6, at, testing::random_normal(generator, 9).reshaped(3, 3)});
      }
      SparseJacobian back = H;
      before.refer_back(dx, back);
      Estimate after = before;
      after.retract(dx);
      const MatrixXd now = H.dense(9, n), then = back.dense(9, n);
      const MatrixXd expected = now * after.P().dense() * now.transpose();
      EXPECT_LE((then * before.P().dense() * then.transpose() - expected).norm(), 1e-10 * expected.norm());
      EXPECT_GT((then - now).norm(), 0.1);
    }
  }
}

TEST(Estimate, ABodyThatIsPlacedKnowsNothingOfItsMapAndTheMapStaysAsItIs) {
  Generator generator(28);
  for (const MotionModel motion : {MotionModel::kImu, MotionModel::kOdometry}) {
    const Estimate before = random_map(generator, 5, {motion});
    Estimate after = before;
    const Pose there = {so3_exp(Vector3d(0.3, -2.0, 0.1)), Vector3d(5.0, 6.0, 7.0)};
    after.place_body(there, 2.0, 0.5, 3.0);
    const Index placed = motion == MotionModel::kOdometry ? 6 : 9, rest = before.size() - placed;
    EXPECT_EQ(after.nav().T_world_body.p, there.p);
    const MatrixXd P = after.P().dense();
    EXPECT_TRUE(P.topRightCorner(placed, rest).isZero(0.0));
    EXPECT_EQ(P.bottomRightCorner(rest, rest), before.P().dense().bottomRightCorner(rest, rest));
    VectorXd sigma(9);
    sigma << 2.0, 2.0, 2.0, 0.5, 0.5, 0.5, 3.0, 3.0, 3.0;
    EXPECT_EQ(P.topLeftCorner(placed, placed), MatrixXd(sigma.head(placed).cwiseAbs2().asDiagonal()));
  }
}

/// How the error state sees all lengths grow by a common factor, per unit of its logarithm.
VectorXd growth_of_all_lengths(const Estimate& estimate) {
  VectorXd g = VectorXd::Zero(estimate.size());
  g.segment<3>(StateLayout::kPosition) = estimate.nav().T_world_body.p;
  g.segment<3>(StateLayout::kVelocity) = estimate.nav().v_world_body;
  g(estimate.layout().map_scale()) = 1.0;
  for (const Landmark& landmark : estimate.landmarks()) {
    if (const Anchor* anchor = estimate.anchor_of(landmark); anchor != nullptr) {
      g.segment<3>(anchor->position_at) = anchor->T_world_body.p;
      g(landmark.at + 2) = -landmark.value.z();
    } else {
      g.segment<3>(landmark.at) = landmark.value;
    }
  }
  return g;
}

StateLayout with_map_scale(MotionModel motion) {
  StateLayout layout{motion};
  layout.has_map_scale = true;
  return layout;
}

TEST(Estimate, RetractionKeepsUnknownAScaleThatNobodyCanSee) {
  Generator generator(18);
  for (const MotionModel motion : {MotionModel::kImu, MotionModel::kConstantVelocity}) {
    Estimate estimate = random_map(generator, 8, with_map_scale(motion));
    const Index n = estimate.size();
    const double sigma = 0.01;
    const VectorXd before = sigma * growth_of_all_lengths(estimate);
    estimate.mutable_P().set_diagonal_block(0,
                                            1e-16 * MatrixXd::Identity(n, n) + before * before.transpose());
    VectorXd dx = 0.05 * testing::random_normal(generator, n);
    estimate.retract(dx);
    const VectorXd after = sigma * growth_of_all_lengths(estimate);
    EXPECT_LE((estimate.P().dense() - after * after.transpose()).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_GT((after - before).cwiseAbs().maxCoeff(), 1e-3 * before.norm());
  }
}

TEST(Estimate, CorrectsTheScaleByAFactor) {
  Generator generator(19);
  for (const double s : {-0.7, -0.1, 0.02, 0.3, 0.49}) {
    const Estimate before = random_map(generator, 8, with_map_scale(MotionModel::kImu));
    Estimate after = before;
    after.retract(s * growth_of_all_lengths(before));
    const double factor = 1.0 / (1.0 - s);  // linear in inverse depths
    EXPECT_LE((after.nav().T_world_body.p - factor * before.nav().T_world_body.p).norm(), 1e-12);
    EXPECT_LE((after.nav().v_world_body - factor * before.nav().v_world_body).norm(), 1e-12);
    for (const Landmark& landmark : before.landmarks()) {
      const Eigen::Vector3d expected = factor * world_position(landmark, before.anchor_of(landmark));
      if (before.anchor_of(landmark) == nullptr) {
        EXPECT_LE((after.landmark_position(*after.find(landmark.track_id)) - expected).norm(), 1e-11);
      } else {
        EXPECT_NEAR(after.find(landmark.track_id)->value.z(), landmark.value.z() / factor, 1e-12);
      }
    }
  }
}

/// Where all points are new, the length of the way behind is not one of theirs: a lift whose cabin comes into
/// view moved its passenger by metres, while depths of the cabin became known.
TEST(Estimate, AScaleOfTheMapAloneMovesNoBody) {
  Generator generator(23);
  const Estimate map = random_map(generator, 8, with_map_scale(MotionModel::kImu));
  const VectorXd all = 0.3 * growth_of_all_lengths(map);
  VectorXd depths = all;
  depths.head(map.layout().map_scale()).setZero();
  for (const Landmark& landmark : map.landmarks()) {
    const Anchor* anchor = map.anchor_of(landmark);
    depths.segment<3>(anchor != nullptr ? anchor->position_at : landmark.at).setZero();
  }
  for (const bool of_map_alone : {true, false}) {
    const VectorXd& g = of_map_alone ? depths : all;
    Estimate estimate = map;
    estimate.mutable_P().set_diagonal_block(
        0, 1e-8 * MatrixXd::Identity(map.size(), map.size()) + g * g.transpose());
    const Estimate::ScaleShares grows = estimate.scale_shares();
    EXPECT_NEAR(grows.position, of_map_alone ? 0.0 : 1.0, 1e-5);
    EXPECT_NEAR(grows.velocity, of_map_alone ? 0.0 : 1.0, 1e-5);
    estimate.retract(g, grows);
    const double factor = of_map_alone ? 1.0 : 1.0 / (1.0 - 0.3);
    EXPECT_LE((estimate.nav().T_world_body.p - factor * map.nav().T_world_body.p).norm(), 1e-3);
    EXPECT_LE((estimate.nav().v_world_body - factor * map.nav().v_world_body).norm(), 1e-3);
    for (const Landmark& landmark : map.landmarks()) {
      if (map.anchor_of(landmark) != nullptr) {
        EXPECT_NEAR(estimate.find(landmark.track_id)->value.z(), landmark.value.z() * 0.7, 1e-9);
      }
    }
  }
}

TEST(Estimate, TakesTheScaleFromThoseThatKnowTheirDepthBest) {
  Generator generator(20);
  Estimate estimate = random_map(generator, 8, with_map_scale(MotionModel::kImu));
  const Index n = estimate.size(), at = estimate.layout().map_scale();
  // All share a scale that is known to 10 %; beside it, some know their depth to 0.3 % and some to 30 %.
  VectorXd own = VectorXd::Constant(n, 1e-8);
  for (const Landmark& landmark : estimate.landmarks()) {
    if (landmark.kind == LandmarkKind::kInverseDepth) {
      const double sigma = (landmark.track_id % 2 == 0 ? 0.003 : 0.3) * landmark.value.z();
      own(landmark.at + 2) = sigma * sigma;
    } else {
      own.segment<3>(landmark.at).setConstant(9.0);
    }
  }
  const VectorXd g = 0.1 * growth_of_all_lengths(estimate);
  estimate.mutable_P().set_diagonal_block(0, MatrixXd(own.asDiagonal()) + g * g.transpose());
  estimate.refresh_map_scale();
  EXPECT_NEAR(std::sqrt(estimate.P().dense()(at, at)), 0.1, 1e-3);
  EXPECT_NEAR(estimate.P().dense()(at, StateLayout::kPosition) / (0.1 * g(StateLayout::kPosition)), 1.0,
              0.01);
}

}  // namespace
}  // namespace limber
