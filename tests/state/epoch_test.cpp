// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "limber/core/so3.hpp"
#include "limber/landmarks/map_management.hpp"
#include "limber/state/estimate.hpp"
#include "limber/update/update.hpp"
#include "small_map.hpp"

/// A map in which some sleep against the same map in which nobody does.
namespace limber {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::Generator;
using testing::random_map;
using testing::snapshot;
using testing::Snapshot;

constexpr int kLandmarks = 12;

/// Random derivatives with respect to the errors as they are now, as those in P: see
/// Estimate::refer_to_epoch.
PointProjection random_projection(const std::function<MatrixXd(Index, Index)>& random,
                                  const Estimate& estimate, const Landmark& landmark) {
  PointProjection out;
  out.J_position = random(2, 3);
  out.J_attitude = random(2, 3);
  out.J_landmark = random(2, 3);
  out.J_anchor_position = random(2, 3);
  out.J_anchor_attitude = random(2, 3);
  if (estimate.anchor_of(landmark) == nullptr) {
    out.J_anchor_position.setZero();
    out.J_anchor_attitude.setZero();
  }
  estimate.refer_to_epoch(landmark, out);
  return out;
}

/// The same random measurement of the body and of the landmarks `ids`, whose anchors count as theirs.
LinearMeasurement measure(Generator generator, const Estimate& estimate,
                          const std::vector<std::int64_t>& ids) {
  std::normal_distribution<double> draw;
  const auto random = [&](Index rows, Index cols) {
    return MatrixXd::NullaryExpr(rows, cols, [&] { return draw(generator); }).eval();
  };
  LinearMeasurement z;
  const Index m = 2 * static_cast<Index>(ids.size());
  z.residual = 0.02 * random(m, 1);
  z.sigma = Eigen::VectorXd::Constant(m, 0.05);
  z.D.resize(m, 0);
  Index row = 0;
  for (const std::int64_t id : ids) {
    const Landmark& landmark = *estimate.find(id);
    const PointProjection projection = random_projection(random, estimate, landmark);
    const auto add = [&](Index at, const MatrixXd& value) { z.H.blocks.push_back({row, at, value}); };
    add(0, projection.J_position);
    add(3, projection.J_attitude);
    add(6, random(2, kTriplet));
    add(landmark.at, projection.J_landmark);
    if (const Anchor* anchor = estimate.anchor_of(landmark); anchor != nullptr) {
      add(anchor->position_at, projection.J_anchor_position);
      add(anchor->attitude_at, projection.J_anchor_attitude);
    }
    row += 2;
  }
  return z;
}

void correct(Estimate& estimate, std::uint64_t seed, const std::vector<std::int64_t>& ids) {
  estimate.retract(update(estimate.mutable_P(), measure(Generator(seed), estimate, ids), {}).dx);
}

/// The body moves on: its error grows.
void move(Estimate& estimate) {
  const Index k = estimate.layout().body_size();
  MatrixXd Phi = MatrixXd::Identity(k, k);
  Phi.block<3, 3>(0, 6) = 0.1 * Matrix3d::Identity();
  Phi.block<3, 3>(3, 3) = so3_exp(Vector3d(0.1, -0.2, 0.05));
  Phi.block<3, 3>(3, 9) = Phi.block<3, 3>(6, 12) = -0.1 * Matrix3d::Identity();  // the biases
  testing::move_body(estimate, [&](NavigationState& nav) {
    nav.T_world_body.R = nav.T_world_body.R * so3_exp(Vector3d(0.1, -0.2, 0.05)).transpose();
  });
  estimate.mutable_P().propagate_leading(Phi, 1e-6 * MatrixXd::Identity(k, k));
}

void expect_same(const Estimate& sleepy, const Estimate& awake,
                 const std::vector<std::int64_t>& without = {}) {
  for (const Landmark& landmark : awake.landmarks()) {
    if (std::find(without.begin(), without.end(), landmark.track_id) != without.end()) {
      continue;
    }
    Matrix3d expected, found;
    const Vector3d p = awake.landmark_position(landmark, &expected);
    const Landmark* other = sleepy.find(landmark.track_id);
    ASSERT_NE(other, nullptr) << landmark.track_id;
    EXPECT_LE((sleepy.landmark_position(*other, &found) - p).norm(), 1e-9) << landmark.track_id;
    EXPECT_LE((found - expected).norm(), 1e-9 * expected.norm()) << landmark.track_id;
  }
  const std::vector<Vector3d> positions = sleepy.landmark_positions();
  for (std::size_t k = 0; k < positions.size(); ++k) {
    EXPECT_LE((sleepy.landmark_position(sleepy.landmarks()[k]) - positions[k]).norm(), 1e-12);
  }
  const Index k = awake.layout().map_begin();
  const MatrixXd body = awake.P().block(0, 0, k, k);
  EXPECT_LE((sleepy.P().block(0, 0, k, k) - body).norm(), 1e-9 * body.norm());
}

/// Everything, when nobody sleeps any more.
void expect_same_snapshot(const Estimate& found, const Estimate& expected) {
  const Snapshot a = snapshot(found), b = snapshot(expected);
  ASSERT_EQ(a.track_ids, b.track_ids);
  ASSERT_EQ(a.mean.size(), b.mean.size());
  EXPECT_LE((a.mean - b.mean).norm(), 1e-9 * b.mean.norm());
  EXPECT_LE((a.P - b.P).norm(), 1e-9 * b.P.norm());
}

/// A thousand times what they begin with. What rounding leaves of a correlation is multiplied by as much, and
/// by more it would be seen.
Estimate::Steps some_steps() {
  Estimate::Steps sigma;
  sigma << Vector3d::Constant(1e-4), Vector3d::Constant(1e-2), 1e-3;  // [rad/s], [m/s^2], [s]
  return sigma;
}

/// One correction an epoch: then the transport that waits for its end is the one that others had at once.
TEST(Epoch, WhoSleepsAndComesBackIsAsIfHeHadBeenAwake) {
  for (const StateLayout& layout : {StateLayout{MotionModel::kImu, false},
                                    StateLayout{MotionModel::kImu, true}, testing::with_supposed_steps()}) {
    Generator generator(5);
    Estimate sleepy = random_map(generator, kLandmarks, layout);
    Estimate awake = sleepy;
    // Landmarks 4 to 6 leave with their anchor, 0 leaves one that others stand on, 3 is Cartesian.
    const std::vector<std::vector<std::int64_t>> retired = {{4, 5, 6}, {0, 3}, {8}, {}, {}};
    const std::vector<std::vector<std::int64_t>> recalled = {{}, {5}, {0, 4}, {3}, {6, 8}};
    std::vector<std::int64_t> in_view = {1, 2, 7, 9, 10, 11};
    for (std::size_t epoch = 0; epoch < retired.size(); ++epoch) {
      sleepy.change_epoch(retired[epoch]);
      sleepy.recall(recalled[epoch]);
      expect_same(sleepy, awake);
      move(sleepy);
      move(awake);
      in_view.insert(in_view.end(), recalled[epoch].begin(), recalled[epoch].end());
      std::erase_if(in_view, [&](std::int64_t id) { return sleepy.find(id)->passive; });
      correct(sleepy, epoch, in_view);
      correct(awake, epoch, in_view);
      if (layout.has_supposed_steps && epoch % 2 == 1) {  // what began in the epoch before
        for (Estimate* estimate : {&sleepy, &awake}) {
          estimate->suppose_steps(some_steps());
          estimate->restart_bias_steps();
        }
      }
    }
    sleepy.change_epoch({});
    EXPECT_FALSE(sleepy.has_frozen());
    expect_same_snapshot(sleepy, awake);
  }
}

/// Then new landmarks of the epoch are there already, and corrections that the passive have not been given
/// yet.
TEST(Epoch, WhoComesBackAmidstAnEpochIsAsIfHeHadBeenAwake) {
  for (const std::vector<std::int64_t>& recalled :
       {std::vector<std::int64_t>{5}, std::vector<std::int64_t>{0, 6, 4}, std::vector<std::int64_t>{3, 8}}) {
    Generator generator(9);
    Estimate sleepy = random_map(generator, kLandmarks);
    Estimate awake = sleepy;
    sleepy.change_epoch({4, 5, 6, 8, 0, 3});
    for (Estimate* estimate : {&sleepy, &awake}) {
      move(*estimate);
      correct(*estimate, 1, {1, 2, 7, 9, 10, 11});
      Landmark fresh;
      fresh.track_id = 100;
      fresh.anchor = estimate->add_anchor(Pose{});
      fresh.value << 0.0, 0.1, 0.3;
      estimate->add_landmark(fresh, 1e-4 * Matrix3d::Identity());
    }
    sleepy.recall(recalled);
    for (Estimate* estimate : {&sleepy, &awake}) {
      estimate->remove_landmark(recalled.front());
    }
    sleepy.change_epoch({});
    expect_same(sleepy, awake);
    std::vector<std::int64_t> others = {4, 5, 6, 8, 0, 3};
    std::erase_if(others, [&](std::int64_t id) {
      return std::find(recalled.begin(), recalled.end(), id) != recalled.end();
    });
    sleepy.recall(others);
    for (Estimate* estimate : {&sleepy, &awake}) {
      correct(*estimate, 2, {1, 2, 100, others.front()});
    }
    sleepy.change_epoch({});
    EXPECT_FALSE(sleepy.has_frozen());
    expect_same_snapshot(sleepy, awake);
  }
}

/// Of those that stay awake P holds the error as it was when the epoch began, and yet the second correction
/// is the same, and the tenth.
TEST(Epoch, WhoStaysAwakeIsCorrectedAsWithoutEpochsHoweverOften) {
  const std::vector<std::int64_t> asleep = {4, 5, 6, 8}, in_view = {0, 1, 2, 3, 7, 9, 10, 11};
  Generator generator(15);
  Estimate sleepy = random_map(generator, kLandmarks);
  Estimate awake = sleepy;
  sleepy.change_epoch(asleep);
  for (std::uint64_t k = 0; k < 10; ++k) {
    const Matrix3d R = awake.nav().T_world_body.R;
    correct(sleepy, k, in_view);
    correct(awake, k, in_view);
    ASSERT_GT((awake.nav().T_world_body.R - R).norm(), 1e-4);
    ASSERT_LT((awake.nav().T_world_body.R - sleepy.nav().T_world_body.R).norm(), 1e-9);
    for (const std::int64_t id : in_view) {
      const Vector3d expected = awake.landmark_position(*awake.find(id));
      EXPECT_LT((sleepy.landmark_position(*sleepy.find(id)) - expected).norm(), 1e-9) << id;
    }
  }
  ASSERT_TRUE(sleepy.has_frozen());
  sleepy.change_epoch({});
  expect_same(sleepy, awake, asleep);
}

/// Whoever sleeps, too.
TEST(Epoch, AMapWhoseDirectionsAreUnknownTurnsAsAWhole) {
  Generator generator(16);
  Estimate estimate = random_map(generator, kLandmarks);
  const MatrixXd turns = testing::gauge(estimate).leftCols<3>();
  const Index n = estimate.size();
  estimate.mutable_P().set_diagonal_block(
      0, 1e-14 * MatrixXd::Identity(n, n) + 0.01 * turns * turns.transpose());
  const Estimate before = estimate;
  estimate.change_epoch({4, 5, 6, 8});
  double turned = 0.0;
  for (int k = 0; k < 4; ++k) {
    LinearMeasurement z;
    z.residual = estimate.nav().T_world_body.R.transpose() * Vector3d(0.04, -0.02, 0.03);
    z.sigma = Vector3d::Constant(0.1);
    z.D.resize(3, 0);
    z.H.blocks.push_back({0, StateLayout::kAttitude, MatrixXd::Identity(3, 3)});
    const Eigen::VectorXd dx = update(estimate.mutable_P(), z, {}).dx;
    estimate.retract(dx);
    turned += dx.segment<3>(StateLayout::kAttitude).norm();
  }
  EXPECT_GT(turned, 0.05);
  const Pose then = before.nav().T_world_body.inverse(), now = estimate.nav().T_world_body.inverse();
  for (const Landmark& landmark : before.landmarks()) {
    const Vector3d x = before.landmark_position(landmark);
    const Vector3d expected = then * x,
                   found = now * estimate.landmark_position(*estimate.find(landmark.track_id));
    EXPECT_LE((found - expected).norm(), std::pow(turned, 3) * x.norm()) << landmark.track_id;
  }
}

TEST(Epoch, ALandmarkCanBeMadeCartesianWhenItsEpochBegins) {
  Generator generator(6);
  Estimate sleepy = random_map(generator, kLandmarks);
  Estimate awake = sleepy;
  sleepy.change_epoch({4, 5, 6, 8});
  for (Estimate* estimate : {&sleepy, &awake}) {
    estimate->convert_to_cartesian(*estimate->find(9));  // 10 still stands on the anchor
    estimate->convert_to_cartesian(*estimate->find(10));
    estimate->convert_to_cartesian(*estimate->find(1));
    correct(*estimate, 1, {1, 2, 3, 7, 9, 10});
  }
  sleepy.change_epoch({});
  sleepy.recall({4, 5, 6, 8});
  correct(sleepy, 2, {1, 4, 5, 8});
  correct(awake, 2, {1, 4, 5, 8});
  sleepy.change_epoch({});
  expect_same_snapshot(sleepy, awake);
}

TEST(Epoch, WhatIsForgottenWhileOthersSleepLeavesNoTrace) {
  Generator generator(7);
  Estimate sleepy = random_map(generator, kLandmarks);
  Estimate awake = sleepy;
  sleepy.change_epoch({4, 5, 6, 8, 0});
  for (Estimate* estimate : {&sleepy, &awake}) {
    estimate->remove_landmark(5);   // asleep, its anchor goes on
    estimate->remove_landmark(8);   // asleep, its anchor awake
    estimate->remove_landmark(3);   // frozen, Cartesian
    estimate->remove_landmark(9);   // frozen ...
    estimate->remove_landmark(10);  // ... and the last that is awake on its anchor
    estimate->remove_landmark(4);
    estimate->remove_landmark(6);  // asleep, the last on its anchor
    const int anchor = estimate->add_anchor(Pose{});
    Landmark fresh;
    fresh.track_id = 100;
    fresh.anchor = anchor;
    fresh.value << 0.0, 0.1, 0.3;
    estimate->add_landmark(fresh, 1e-4 * Matrix3d::Identity());
    Landmark other = fresh;
    other.track_id = 101;
    estimate->add_landmark(other, 1e-4 * Matrix3d::Identity());
    estimate->remove_landmark(100);
    correct(*estimate, 1, {1, 2, 7, 101});
  }
  sleepy.change_epoch({});
  sleepy.recall({0});
  sleepy.change_epoch({});
  EXPECT_EQ(sleepy.size(), awake.size());
  EXPECT_FALSE(sleepy.has_frozen());
  expect_same(sleepy, awake);
}

StereoFrame sees(std::int64_t t_ns, const std::vector<std::int64_t>& ids) {
  StereoFrame frame;
  frame.t_ns = t_ns;
  for (const std::int64_t id : ids) {
    StereoObservation observation;
    observation.track_id = id;
    observation.in_cam0 = true;
    frame.observations.push_back(observation);
  }
  return frame;
}

constexpr std::int64_t kSecond = 1000000000;

/// At 11 s, of which the landmarks from 6 on were seen then, and the others a second before.
Estimate half_seen_map(Generator& generator) {
  Estimate estimate = random_map(generator, kLandmarks);
  for (Landmark& landmark : estimate.landmarks()) {
    landmark.last_seen_ns = landmark.track_id < 6 ? 10 * kSecond : 11 * kSecond;
  }
  testing::move_body(estimate, [&](NavigationState& nav) { nav.t_ns = 11 * kSecond; });
  return estimate;
}

MapManagementOptions without_conversions() {
  MapManagementOptions options;
  options.linearity_index = 0.0;
  return options;
}

TEST(RestAndRecall, OfAMapThatIsHandedOverTheUnseenRestAtOnceAndNoWorkWaits) {
  Generator generator(9);
  Estimate estimate = half_seen_map(generator);
  const MapManagementOptions options = without_conversions();
  rest_unseen(estimate, 11 * kSecond, options);
  for (const Landmark& landmark : estimate.landmarks()) {
    EXPECT_EQ(landmark.passive, landmark.track_id < 6) << landmark.track_id;
  }
  const testing::Snapshot handed_over = testing::snapshot(estimate);
  estimate.settle();
  EXPECT_EQ(testing::snapshot(estimate), handed_over);  // not even by rounding
  // The first frame ends no epoch.
  testing::move_body(estimate, [&](NavigationState& nav) { nav.t_ns = 11 * kSecond + kSecond / 20; });
  update_active_set(estimate, sees(estimate.nav().t_ns, {7}), 11 * kSecond, options);
  EXPECT_EQ(estimate.epoch_began_ns(), 11 * kSecond);
}

TEST(RestAndRecall, TheUnseenRestAndTheSeenComeBack) {
  Generator generator(8);
  Estimate estimate = half_seen_map(generator);
  MapManagementOptions options = without_conversions();
  update_active_set(estimate, sees(11 * kSecond, {7}), 11 * kSecond, options);
  for (const Landmark& landmark : estimate.landmarks()) {
    EXPECT_EQ(landmark.passive, landmark.track_id < 6) << landmark.track_id;
  }
  EXPECT_EQ(estimate.epoch_began_ns(), 11 * kSecond);
  // Nothing is due within the epoch, but somebody asleep who is seen comes back at once.
  testing::move_body(estimate, [&](NavigationState& nav) { nav.t_ns = 11 * kSecond + kSecond / 4; });
  update_active_set(estimate, sees(estimate.nav().t_ns, {7}), 11 * kSecond, options);
  EXPECT_EQ(estimate.epoch_began_ns(), 11 * kSecond);
  update_active_set(estimate, sees(estimate.nav().t_ns, {7, 2}), 11 * kSecond, options);
  EXPECT_EQ(estimate.epoch_began_ns(), 11 * kSecond);
  EXPECT_FALSE(estimate.find(2)->passive);
  EXPECT_TRUE(estimate.find(3)->passive);

  // Due, and put off for a frame.
  testing::move_body(estimate, [&](NavigationState& nav) { nav.t_ns = 12 * kSecond; });
  update_active_set(estimate, sees(estimate.nav().t_ns, {7}), 11 * kSecond, options, false);
  EXPECT_EQ(estimate.epoch_began_ns(), 11 * kSecond);
  update_active_set(estimate, sees(estimate.nav().t_ns, {7}), 11 * kSecond, options);
  EXPECT_EQ(estimate.epoch_began_ns(), 12 * kSecond);

  options.rest_after_s = 1e9;
  Estimate sleepless = random_map(generator, kLandmarks);
  update_active_set(sleepless, sees(20 * kSecond, {}), 11 * kSecond, options);
  EXPECT_FALSE(sleepless.has_frozen());
}

}  // namespace
}  // namespace limber
