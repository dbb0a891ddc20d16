// SPDX-License-Identifier: MIT
#include "limber/datasets/interpolate.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "limber/core/so3.hpp"
#include "limber/evaluate/association.hpp"

namespace limber {
namespace {

constexpr std::int64_t kMs = 1'000'000;

// Two samples 40 ms apart; the second turned by 0.8 rad about its own x axis.
std::vector<GroundTruthState> two_samples() {
  GroundTruthState a;
  a.t_ns = 1317384506402996993;
  a.R_world_body = so3_exp({0.5, 2.0, -1.0});
  a.p_world_body = {1, 2, 3};
  a.v_world_body = {0, 1, 0};
  a.bias_gyro = {0.1, 0, 0};
  GroundTruthState b = a;
  b.t_ns += 40 * kMs;
  b.R_world_body = a.R_world_body * so3_exp({0.8, 0, 0});
  b.p_world_body = {2, 4, -3};
  b.v_world_body = {4, 1, 0};
  b.bias_accel = {0, 0.4, 0};
  return {a, b};
}

TEST(GroundtruthAt, InterpolatesBetweenSamples) {
  const auto samples = two_samples();
  const auto state = groundtruth_at(samples, samples[0].t_ns + 10 * kMs);
  ASSERT_TRUE(state.has_value());
  EXPECT_EQ(state->t_ns, samples[0].t_ns + 10 * kMs);
  EXPECT_LE((state->p_world_body - Eigen::Vector3d(1.25, 2.5, 1.5)).norm(), 1e-15);
  EXPECT_LE((state->v_world_body - Eigen::Vector3d(1, 1, 0)).norm(), 1e-15);
  EXPECT_LE((state->bias_gyro - Eigen::Vector3d(0.1, 0, 0)).norm(), 1e-15);
  EXPECT_LE((state->bias_accel - Eigen::Vector3d(0, 0.1, 0)).norm(), 1e-15);
  EXPECT_LE((state->R_world_body - samples[0].R_world_body * so3_exp({0.2, 0, 0})).norm(), 1e-14);
}

TEST(GroundtruthAt, IsTheSampleItselfAtItsTime) {
  const auto samples = two_samples();
  for (const GroundTruthState& sample : samples) {
    const auto state = groundtruth_at(samples, sample.t_ns, 0);
    ASSERT_TRUE(state.has_value());
    EXPECT_EQ(state->p_world_body, sample.p_world_body);
    EXPECT_LE((state->R_world_body - sample.R_world_body).norm(), 1e-15);
  }
}

TEST(GroundtruthAt, IsNothingFarFromEverySample) {
  const auto samples = two_samples();
  EXPECT_FALSE(groundtruth_at(samples, samples[0].t_ns + 11 * kMs).has_value());
  EXPECT_FALSE(groundtruth_at(samples, samples[1].t_ns - 11 * kMs).has_value());
  EXPECT_TRUE(groundtruth_at(samples, samples[1].t_ns - 10 * kMs).has_value());
  EXPECT_TRUE(groundtruth_at(samples, samples[0].t_ns + 11 * kMs, 12 * kMs).has_value());
  EXPECT_FALSE(groundtruth_at({}, 0).has_value());
}

TEST(GroundtruthAt, ContinuesTheMotionAtTheEndsForMaxGap) {
  const auto samples = two_samples();
  const auto before = groundtruth_at(samples, samples[0].t_ns - 10 * kMs);
  ASSERT_TRUE(before.has_value());
  EXPECT_LE((before->p_world_body - Eigen::Vector3d(0.75, 1.5, 4.5)).norm(), 1e-14);
  EXPECT_LE((before->R_world_body - samples[0].R_world_body * so3_exp({-0.2, 0, 0})).norm(), 1e-14);
  EXPECT_EQ(before->t_ns, samples[0].t_ns - 10 * kMs);
  const auto after = groundtruth_at(samples, samples[1].t_ns + 10 * kMs);
  ASSERT_TRUE(after.has_value());
  EXPECT_LE((after->v_world_body - Eigen::Vector3d(5, 1, 0)).norm(), 1e-14);
  EXPECT_FALSE(groundtruth_at(samples, samples[0].t_ns - 11 * kMs).has_value());
  EXPECT_FALSE(groundtruth_at(samples, samples[1].t_ns + 11 * kMs).has_value());
}

TEST(GroundtruthAt, IsWhatMatchingInTimeGives) {
  const auto samples = two_samples();
  std::vector<StampedPose> truth, estimate;
  for (const GroundTruthState& sample : samples) {
    truth.push_back({sample.t_ns, {sample.R_world_body, sample.p_world_body}});
  }
  for (const std::int64_t offset : {-10, -3, 0, 7, 32, 40, 46, 50}) {
    estimate.push_back({samples[0].t_ns + offset * kMs, {}});
  }
  const auto matched = match_by_time(estimate, truth);
  ASSERT_EQ(matched.size(), estimate.size());
  for (const MatchedPose& pose : matched) {
    const auto state = groundtruth_at(samples, pose.t_ns);
    ASSERT_TRUE(state.has_value());
    EXPECT_LE((state->p_world_body - pose.truth.p).norm(), 1e-14);
    EXPECT_LE((state->R_world_body - pose.truth.R).norm(), 1e-14);
  }
}

TEST(GroundtruthAt, HoldsALoneSample) {
  const std::vector<GroundTruthState> lone = {two_samples()[0]};
  const auto state = groundtruth_at(lone, lone[0].t_ns + 10 * kMs);
  ASSERT_TRUE(state.has_value());
  EXPECT_EQ(state->p_world_body, lone[0].p_world_body);
}

TEST(CalibrationAt, IsTheLatestSampleAtOrBeforeTheTime) {
  const std::vector<TrueRig> truth = {{100, RigParameters::Constant(1)}, {200, RigParameters::Constant(2)}};
  EXPECT_EQ(true_rig_at(truth, 50).theta[0], 1.0) << "before the first sample: the first";
  EXPECT_EQ(true_rig_at(truth, 100).theta[0], 1.0);
  EXPECT_EQ(true_rig_at(truth, 199).theta[0], 1.0) << "a step is not smeared";
  EXPECT_EQ(true_rig_at(truth, 200).theta[0], 2.0);
  EXPECT_EQ(true_rig_at(truth, 1000).theta[0], 2.0);
  EXPECT_THROW(static_cast<void>(true_rig_at({}, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace limber
