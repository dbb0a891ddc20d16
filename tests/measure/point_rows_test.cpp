// SPDX-License-Identifier: MIT
#include "limber/measure/point_rows.hpp"

#include <gtest/gtest.h>

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;

constexpr Index kRows = 4;
constexpr Index kRow = 2;

/// A projection whose Jacobians are told apart by their value.
PointProjection marked_projection() {
  PointProjection out;
  out.uv << 100.0, 200.0;
  out.J_position.setConstant(1.0);
  out.J_attitude.setConstant(2.0);
  out.J_landmark.setConstant(3.0);
  out.J_anchor_position.setConstant(4.0);
  out.J_anchor_attitude.setConstant(5.0);
  out.J_theta.leftCols<3>().setConstant(6.0);
  out.J_theta.rightCols<3>().setConstant(7.0);
  return out;
}

/// Rows 2 and 3 written, rows 0 and 1 left alone.
LinearMeasurement written(const StateLayout& layout, const PointProjection& projection,
                          const Anchor* anchor) {
  Landmark landmark;
  landmark.at = 30;
  LinearMeasurement z = empty_measurement(kRows);
  write_point_rows(z, kRow, {101.0, 198.0}, {0.5, 0.7}, projection, landmark, anchor, layout);
  return z;
}

TEST(PointRows, ResidualIsMeasuredMinusProjected) {
  const LinearMeasurement z = written({MotionModel::kImu, false}, marked_projection(), nullptr);
  EXPECT_EQ(z.residual.segment<2>(kRow), Vector2d(1.0, -2.0));
  EXPECT_EQ(z.sigma.segment<2>(kRow), Vector2d(0.5, 0.7));
  EXPECT_EQ(z.residual.head<2>(), Vector2d::Zero());
}

TEST(PointRows, EachJacobianGoesToItsPlaceInH) {
  Anchor anchor;
  anchor.position_at = 15;
  anchor.attitude_at = 21;
  const MatrixXd H = written({MotionModel::kImu, false}, marked_projection(), &anchor).H.dense(kRows, 33);
  Eigen::RowVectorXd expected = Eigen::RowVectorXd::Zero(33);
  expected.segment<3>(0).setConstant(1.0);
  expected.segment<3>(3).setConstant(2.0);
  expected.segment<3>(30).setConstant(3.0);
  expected.segment<3>(15).setConstant(4.0);
  expected.segment<3>(21).setConstant(5.0);
  EXPECT_TRUE(H.topRows<2>().isZero(0.0));
  EXPECT_EQ(H.row(kRow), expected);
  EXPECT_EQ(H.row(kRow + 1), expected);
}

TEST(PointRows, ThetaGoesToDWhenItIsNotInTheState) {
  const LinearMeasurement z = written({MotionModel::kImu, false}, marked_projection(), nullptr);
  ASSERT_EQ(z.D.rows(), kRows);
  ASSERT_EQ(z.D.cols(), 6);
  EXPECT_TRUE(z.D.topRows<2>().isZero(0.0));
  EXPECT_EQ(MatrixXd(z.D.bottomRows<2>()), MatrixXd(marked_projection().J_theta));
}

TEST(PointRows, ThetaGoesToHAsWellWhenItIsInTheState) {
  const StateLayout layout{MotionModel::kConstantVelocity, true};
  const LinearMeasurement z = written(layout, marked_projection(), nullptr);
  EXPECT_EQ(MatrixXd(z.D.bottomRows<2>()), MatrixXd(marked_projection().J_theta));
  const MatrixXd H = z.H.dense(kRows, 33);
  EXPECT_EQ(MatrixXd(H.block(kRow, layout.theta(), 2, 6)), MatrixXd(marked_projection().J_theta));
}

TEST(PointRows, AZeroThetaJacobianCostsNoBlock) {
  PointProjection projection = marked_projection();
  projection.J_theta.setZero();
  EXPECT_EQ(written({MotionModel::kImu, true}, projection, nullptr).H.blocks.size(), 3U);
}

}  // namespace
}  // namespace limber
