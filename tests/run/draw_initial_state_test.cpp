// SPDX-License-Identifier: MIT
#include "limber/run/draw_initial_state.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "limber/core/so3.hpp"

namespace limber {
namespace {

// 300 draws of three axes: five standard deviations of an estimated variance.
TEST(DrawInitialState, AddsErrorsOfTheStatedSizes) {
  GroundTruthState truth;
  truth.t_ns = 5;
  truth.R_world_body = so3_exp({0.1, 2.0, -0.3});
  truth.p_world_body = Eigen::Vector3d(1.0, 2.0, 3.0);
  truth.v_world_body = Eigen::Vector3d(4.0, 5.0, 6.0);
  truth.bias_gyro = Eigen::Vector3d::Constant(0.08);
  const InitialSigma sigmas{0.1, 0.02, 0.3, 0.4, 0.5};
  double p = 0.0, R = 0.0, v = 0.0, a = 0.0, g = 0.0;
  constexpr int kRuns = 300, kValues = 3 * kRuns;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const GroundTruthState s = draw_initial_state(truth, sigmas, 1, run);
    EXPECT_EQ(s.t_ns, 5);
    p += (s.p_world_body - truth.p_world_body).squaredNorm() / (kValues * 0.01);
    R += so3_log(truth.R_world_body.transpose() * s.R_world_body).squaredNorm() / (kValues * 0.0004);
    v += (s.v_world_body - truth.v_world_body).squaredNorm() / (kValues * 0.09);
    a += (s.bias_accel - truth.bias_accel).squaredNorm() / (kValues * 0.16);
    g += (s.bias_gyro - truth.bias_gyro).squaredNorm() / (kValues * 0.25);
  }
  for (const double ratio : {p, R, v, a, g}) {
    EXPECT_NEAR(ratio, 1.0, 5.0 * std::sqrt(2.0 / kValues));
  }
}

TEST(DrawInitialState, IsTheTruthForSigmasOfZero) {
  GroundTruthState truth;
  truth.t_ns = 7;
  truth.R_world_body = so3_exp({0.1, 2.0, -0.3});
  truth.p_world_body = Eigen::Vector3d(1.0, 2.0, 3.0);
  truth.v_world_body = Eigen::Vector3d(4.0, 5.0, 6.0);
  truth.bias_accel = Eigen::Vector3d::Constant(-0.2);
  const GroundTruthState drawn = draw_initial_state(truth, {0.0, 0.0, 0.0, 0.0, 0.0}, 1);
  EXPECT_EQ(drawn.t_ns, truth.t_ns);
  EXPECT_TRUE(drawn.R_world_body.isApprox(truth.R_world_body, 1e-15));
  EXPECT_EQ(drawn.p_world_body, truth.p_world_body);
  EXPECT_EQ(drawn.v_world_body, truth.v_world_body);
  EXPECT_EQ(drawn.bias_accel, truth.bias_accel);
  EXPECT_EQ(drawn.bias_gyro, truth.bias_gyro);
}

}  // namespace
}  // namespace limber
