// SPDX-License-Identifier: MIT
#include "limber/smooth/causal_smoother.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "smoother_case.hpp"

namespace limber {
namespace {

using testing::bent;
using testing::Case;
using testing::expect_chi_square;
using testing::kBent;
using testing::nees;
using testing::pose_error;
using testing::small_scenario;

constexpr double kAll = 60.0;  // [s], longer than any recording here

/// A recording's first frames, as input.
SmootherInput first_frames(const Case& c, std::size_t count) {
  return {std::span(c.recording.frames).first(count), c.recording.imu, c.recording.odometry,
          std::span(c.start).first(count), c.prior};
}

SmootherResult causal(const Case& c, const Horizon& horizon, std::size_t count) {
  return smooth_causally(first_frames(c, count), c.recording.calibration, c.options, horizon);
}

/// The iteration ends where a step gains a millionth of the cost: some hundredths of a standard deviation.
void expect_same_frame(const SmoothedFrame& a, const SmoothedFrame& b) {
  const double sigma = std::sqrt(b.pose_covariance.diagonal().head<3>().maxCoeff());
  EXPECT_LT((a.nav.T_world_body.p - b.nav.T_world_body.p).norm(), 0.1 * sigma);
  EXPECT_LT((a.pose_covariance - b.pose_covariance).norm(), 0.01 * b.pose_covariance.norm());
  EXPECT_LT((a.motion_covariance - b.motion_covariance).norm(), 0.01 * b.motion_covariance.norm());
  EXPECT_LT((a.theta - b.theta).norm(), 0.1 * std::sqrt(b.theta_covariance.trace()) + 1e-12);
  EXPECT_LT((a.theta_covariance - b.theta_covariance).norm(), 0.01 * b.theta_covariance.norm() + 1e-12);
}

TEST(CausalSmoother, OverAllFramesSoFarIsTheSmootherOfThemAlone) {
  for (const RigModel rig : {RigModel::kTrusted, RigModel::kConstant, RigModel::kFree}) {
    SCOPED_TRACE(static_cast<int>(rig));
    Case c(rig == RigModel::kTrusted ? small_scenario() : bent(small_scenario()), MotionModel::kImu, 3);
    c.options.rig = rig;
    c.options.loss = RobustLoss::kNone;
    const SmootherResult moving = causal(c, {5, kAll}, c.recording.frames.size());
    ASSERT_EQ(moving.frames.size(), c.recording.frames.size());
    for (const std::size_t newest : {std::size_t{5}, std::size_t{12}, c.recording.frames.size() - 1}) {
      SCOPED_TRACE(newest);
      const SmootherResult batch = smooth(first_frames(c, newest + 1), c.recording.calibration, c.options);
      expect_same_frame(moving.frames[newest], batch.frames.back());
    }
    const SmootherResult begin = smooth(first_frames(c, 6), c.recording.calibration, c.options);
    expect_same_frame(moving.frames[2], begin.frames[2]);
  }
}

TEST(CausalSmoother, NoRowDependsOnALaterFrame) {
  Case c(bent(small_scenario()), MotionModel::kImu, 4);
  const SmootherResult all = causal(c, {3, 0.45}, c.recording.frames.size());
  const SmootherResult half = causal(c, {3, 0.45}, 11);
  ASSERT_EQ(half.frames.size(), 11U);
  for (std::size_t k = 0; k < half.frames.size(); ++k) {
    EXPECT_LT((all.frames[k].nav.T_world_body.p - half.frames[k].nav.T_world_body.p).norm(), 1e-9) << k;
    EXPECT_LT((all.frames[k].pose_covariance - half.frames[k].pose_covariance).norm(), 1e-9) << k;
  }
}

void expect_short_window_consistent(int runs) {
  const double dof = 6.0 * runs;
  for (const RigModel rig :
       {RigModel::kTrusted, RigModel::kConstant, RigModel::kPiecewise, RigModel::kWalk, RigModel::kFree}) {
    SCOPED_TRACE(static_cast<int>(rig));
    double middle = 0.0, last = 0.0, theta = 0.0;
    for (int run = 0; run < runs; ++run) {
      Case c(rig == RigModel::kTrusted ? small_scenario() : bent(small_scenario()), MotionModel::kImu,
             static_cast<std::uint64_t>(200 + run));
      c.options.rig = rig;
      c.options.piece_s = 0.7;
      c.options.rig_walk.setConstant(1e-12);
      c.options.loss = RobustLoss::kNone;
      const SmootherResult result = causal(c, {3, 0.55}, c.recording.frames.size());
      ASSERT_TRUE(result.converged);
      const auto at = [&](std::size_t k) {
        return nees(pose_error(c.truth[k], result.frames[k].nav), result.frames[k].pose_covariance);
      };
      middle += at(result.frames.size() / 2);
      last += at(result.frames.size() - 1);
      if (rig != RigModel::kTrusted && rig != RigModel::kFree) {
        const SmoothedFrame& frame = result.frames.back();
        theta += nees(c.recording.calibration.theta + kBent - frame.theta, frame.theta_covariance);
      }
    }
    expect_chi_square(middle, dof);
    expect_chi_square(last, dof);
    if (theta > 0.0) {
      expect_chi_square(theta, dof);
    }
  }
}

TEST(CausalSmoother, OfAShortWindowKnowsHowWellItKnows) { expect_short_window_consistent(3); }

TEST(FullCausalSmoother, OfAShortWindowKnowsHowWellItKnows) { expect_short_window_consistent(12); }

TEST(CausalSmoother, CarriesWhatItKnowsOfTheRigBeyondTheWindow) {
  Case c(bent(small_scenario()), MotionModel::kImu, 5);
  c.options.rig = RigModel::kConstant;
  c.options.loss = RobustLoss::kNone;
  const std::size_t n = c.recording.frames.size();
  const auto sigma = [](const SmootherResult& result) {
    return std::sqrt(result.frames.back().theta_covariance.topLeftCorner(3, 3).trace());
  };
  const double carried = sigma(causal(c, {3, 0.55}, n));
  EXPECT_LT(carried, 1.5 * sigma(c.solve()));
  const double window_alone = sigma(smooth({std::span(c.recording.frames).last(6), c.recording.imu,
                                            c.recording.odometry, std::span(c.start).last(6), c.prior},
                                           c.recording.calibration, c.options));
  EXPECT_LT(carried, 0.8 * window_alone);
}

TEST(CausalSmoother, CarriesAWrongFocalLengthToo) {
  Case c(small_scenario(), MotionModel::kImu, 4);
  c.recording.calibration.cam1.fu += 3.0;
  c.options.rig = RigModel::kTrusted;
  c.options.estimated(12) = 5.0;
  const SmootherResult result = causal(c, {3, 0.55}, c.recording.frames.size());
  const SmoothedFrame &early = result.frames[5], &last = result.frames.back();
  EXPECT_NEAR(last.error(12), -3.0, 4.0 * last.error_sigma(12));
  EXPECT_LT(last.error_sigma(12), 0.7 * early.error_sigma(12));
}

TEST(CausalSmoother, CrossesAGapThatIsLongerThanItsWindow) {
  Case c(small_scenario(), MotionModel::kImu, 6);
  c.options.rig = RigModel::kTrusted;
  c.recording.frames.erase(c.recording.frames.begin() + 9, c.recording.frames.begin() + 14);
  c.start.erase(c.start.begin() + 9, c.start.begin() + 14);
  c.truth.erase(c.truth.begin() + 9, c.truth.begin() + 14);
  const SmootherResult result = causal(c, {3, 0.35}, c.recording.frames.size());
  const auto sigma = [&](std::size_t k) { return std::sqrt(result.frames[k].pose_covariance(0, 0)); };
  EXPECT_GT(sigma(9), sigma(8));
  EXPECT_LT(nees(pose_error(c.truth.back(), result.frames.back().nav), result.frames.back().pose_covariance),
            chi_square_quantile(1.0 - testing::kFalseAlarm, 6.0));
}

TEST(CausalSmoother, RefusesAWindowOfNothing) {
  const Case c(small_scenario(), MotionModel::kImu, 1);
  EXPECT_THROW(static_cast<void>(causal(c, {0, 0.0}, 5)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(causal(c, {5, 1.0}, 5)), std::invalid_argument);
}

}  // namespace
}  // namespace limber
