// SPDX-License-Identifier: MIT
#include "limber/smooth/smoother.hpp"
#include "limber/core/factors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "limber/core/chi_square.hpp"
#include "smoother_case.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;

using testing::bent;
using testing::Case;
using testing::expect_chi_square;
using testing::kBent;
using testing::kFalseAlarm;
using testing::nees;
using testing::pose_error;
using testing::small_scenario;

TEST(Smoother, IsConsistentForEveryModelOfTheRigThatCanBeTrue) {
  constexpr int kRuns = 8;
  for (const RigModel rig :
       {RigModel::kTrusted, RigModel::kConstant, RigModel::kPiecewise, RigModel::kFree}) {
    SCOPED_TRACE(static_cast<int>(rig));
    double middle = 0.0, last = 0.0, theta = 0.0, residuals = 0.0, dof = 0.0;
    for (int run = 0; run < kRuns; ++run) {
      const Scenario scenario = rig == RigModel::kTrusted ? small_scenario() : bent(small_scenario());
      Case c(scenario, MotionModel::kImu, static_cast<std::uint64_t>(run));
      c.options.rig = rig;
      c.options.piece_s = 0.7;
      c.options.loss = RobustLoss::kNone;
      const SmootherResult result = c.solve();
      ASSERT_TRUE(result.converged);
      const auto at = [&](std::size_t k) {
        return nees(pose_error(c.truth[k], result.frames[k].nav), result.frames[k].pose_covariance);
      };
      middle += at(result.frames.size() / 2);
      last += at(result.frames.size() - 1);
      residuals += result.squared_residuals;
      dof += static_cast<double>(result.dof);
      if (rig == RigModel::kConstant || rig == RigModel::kPiecewise) {
        const SmoothedFrame& frame = result.frames[result.frames.size() / 2];
        theta += nees(c.recording.calibration.theta + kBent - frame.theta, frame.theta_covariance);
      }
    }
    expect_chi_square(middle, 6.0 * kRuns);
    expect_chi_square(last, 6.0 * kRuns);
    expect_chi_square(residuals, dof);
    if (theta > 0.0) {
      expect_chi_square(theta, 6.0 * kRuns);
    }
  }
}

VectorXd motion_error(MotionModel motion, const NavigationState& truth, const NavigationState& estimate) {
  VectorXd out(motion == MotionModel::kImu ? 9 : 3);
  out.head<3>() = truth.v_world_body - estimate.v_world_body;
  if (motion == MotionModel::kImu) {
    out.segment<3>(3) = truth.bias_gyro - estimate.bias_gyro;
    out.segment<3>(6) = truth.bias_accel - estimate.bias_accel;
  }
  return out;
}

TEST(Smoother, VelocitiesAndBiasesAreAsFarOffAsTheirBoundsSay) {
  constexpr int kRuns = 24;
  for (const RigModel rig : {RigModel::kTrusted, RigModel::kFree}) {
    SCOPED_TRACE(static_cast<int>(rig));
    std::map<std::size_t, double> sums;
    Eigen::Vector3d parts =
        Eigen::Vector3d::Zero();  // velocity, gyro bias, accelerometer bias of the last frame
    for (int run = 0; run < kRuns; ++run) {
      Case c(rig == RigModel::kTrusted ? small_scenario() : bent(small_scenario()), MotionModel::kImu,
             static_cast<std::uint64_t>(100 + run));
      c.options.rig = rig;
      c.options.loss = RobustLoss::kNone;
      const SmootherResult result = c.solve();
      ASSERT_TRUE(result.converged);
      for (const std::size_t k : {std::size_t{0}, result.frames.size() / 2, result.frames.size() - 1}) {
        const SmoothedFrame& frame = result.frames[k];
        const VectorXd error = motion_error(MotionModel::kImu, c.truth[k], frame.nav);
        sums[k] += nees(error, frame.motion_covariance);
        for (int part = 0; k + 1 == result.frames.size() && part < 3; ++part) {
          parts(part) +=
              nees(error.segment(3 * part, 3), frame.motion_covariance.block(3 * part, 3 * part, 3, 3));
        }
      }
    }
    for (const auto& [frame, sum] : sums) {
      SCOPED_TRACE(frame);
      expect_chi_square(sum, 9.0 * kRuns);
    }
    for (int part = 0; part < 3; ++part) {
      SCOPED_TRACE(part);
      expect_chi_square(parts(part), 3.0 * kRuns);
    }
  }
}

TEST(Smoother, HasNoBoundsOfVelocityWhereNoneAreWantedOrKnown) {
  Case c(small_scenario(), MotionModel::kImu, 1);
  c.options.covariance = false;
  EXPECT_EQ(c.solve().frames.front().motion_covariance.size(), 0);
  Case odometry(small_scenario(), MotionModel::kOdometry, 1);
  EXPECT_EQ(odometry.solve().frames.front().motion_covariance.size(), 0);
}

TEST(Smoother, OdometryAndConstantVelocityAreConsistentToo) {
  constexpr int kRuns = 8;
  double odometry = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Case c(bent(small_scenario()), MotionModel::kOdometry, static_cast<std::uint64_t>(run));
    c.options.rig = RigModel::kConstant;
    c.options.loss = RobustLoss::kNone;
    const SmootherResult result = c.solve();
    odometry +=
        nees(pose_error(c.truth.back(), result.frames.back().nav), result.frames.back().pose_covariance);
  }
  expect_chi_square(odometry, 6.0 * kRuns);

  Case c(small_scenario(), MotionModel::kConstantVelocity, 1);
  c.options.rig = RigModel::kTrusted;
  const SmootherResult result = c.solve();
  ASSERT_TRUE(result.converged);
  EXPECT_LT(nees(pose_error(c.truth.back(), result.frames.back().nav), result.frames.back().pose_covariance),
            chi_square_quantile(1.0 - kFalseAlarm, 6.0));
  const MatrixXd& motion = result.frames.back().motion_covariance;
  ASSERT_EQ(motion.rows(), 6) << "velocity and rate";
  EXPECT_LT(nees(motion_error(MotionModel::kConstantVelocity, c.truth.back(), result.frames.back().nav),
                 motion.topLeftCorner(3, 3)),
            chi_square_quantile(1.0 - kFalseAlarm, 3.0));
}

TEST(Smoother, GrossMismatchesAreRefusedAndDoNoHarm) {
  Case clean(bent(small_scenario()), MotionModel::kImu, 3);
  clean.options.rig = RigModel::kConstant;
  const SmootherResult good = clean.solve();
  Case c = clean;
  Generator generator(9);
  std::size_t wrong = 0;
  for (StereoFrame& frame : c.recording.frames) {
    for (StereoObservation& seen : frame.observations) {
      if (testing::random_scalar(generator, 0.0, 1.0) < 0.1) {
        (testing::random_scalar(generator, 0.0, 1.0) < 0.5 ? seen.uv_cam0 : seen.uv_cam1) +=
            30.0 * testing::random_direction(generator).head<2>().normalized();
        ++wrong;
      }
    }
  }
  const SmootherResult robust = c.solve();
  c.options.loss = RobustLoss::kNone;
  const SmootherResult naive = c.solve();
  const auto error = [&](const SmootherResult& r) {
    double sum = 0.0;
    for (std::size_t k = 0; k < r.frames.size(); ++k) {
      sum += pose_error(c.truth[k], r.frames[k].nav).head<3>().squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(r.frames.size()));
  };
  EXPECT_LT(error(robust), 1.3 * error(good) + 0.002);
  EXPECT_GT(error(naive), 2.0 * error(good));
  EXPECT_GE(robust.refused.size(), wrong * 9 / 10);
  EXPECT_LE(good.refused.size(), 10U);
}

TEST(Smoother, AWalkFollowsARigThatMoves) {
  Scenario scenario = small_scenario();
  scenario.decalibration = {{kBent, ConstantShape{}}};
  Case c(scenario, MotionModel::kImu, 2);
  c.options.rig = RigModel::kWalk;
  c.options.rig_walk.setConstant(1e-6);
  const SmootherResult result = c.solve();
  const SmoothedFrame& frame = result.frames[result.frames.size() / 2];
  const RigParameters error = c.recording.calibration.theta + kBent - frame.theta;
  EXPECT_LT(nees(error, frame.theta_covariance), chi_square_quantile(1.0 - kFalseAlarm, 6.0));
  EXPECT_LT(error.head<3>().norm(), 0.002);
}

TEST(Smoother, FindsAWrongFocalLength) {
  Case c(small_scenario(), MotionModel::kImu, 4);
  StereoCalibration& calibration = c.recording.calibration;
  calibration.cam1.fu += 3.0;
  calibration.cam1.fv += 3.0;
  c.options.rig = RigModel::kTrusted;
  c.options.estimated(12) = c.options.estimated(13) = 5.0;
  const SmootherResult result = c.solve();
  for (const Eigen::Index k : {12, 13}) {
    EXPECT_GT(result.frames.back().error_sigma(k), 0.0);
    EXPECT_LT(result.frames.back().error_sigma(k), 1.0);
    EXPECT_NEAR(result.frames.back().error(k), -3.0, 4.0 * result.frames.back().error_sigma(k));
  }
}

/// The recording without the points of one cell of its left images.
Recording without_cell(Recording recording, int cell) {
  std::map<std::int64_t, int> first;
  for (StereoFrame& frame : recording.frames) {
    for (const StereoObservation& o : frame.observations) {
      if (o.in_cam0) first.try_emplace(o.track_id, image_cell(recording.calibration.cam0, o.uv_cam0));
    }
    std::erase_if(frame.observations, [&](const StereoObservation& o) {
      return first.contains(o.track_id) && first.at(o.track_id) == cell;
    });
  }
  return recording;
}

TEST(Smoother, ScoresOfACellTellWhatTheRigWouldBeWithoutItsPoints) {
  Case c(bent(small_scenario()), MotionModel::kImu, 0);
  c.options.rig = RigModel::kConstant;
  c.options.loss = RobustLoss::kNone;  // so that no pixel's weight changes
  const SmootherResult all = c.solve();
  const MatrixXd covariance = all.frames.front().theta_covariance;
  RigMatrix information = RigMatrix::Zero();
  for (const auto& [cell, score] : all.theta_scores) information += score.information;
  ASSERT_GE(all.theta_scores.size(), 8u);
  double wrong = 0.0, moved = 0.0, first_order = 0.0;
  for (const auto& [cell, score] : all.theta_scores) {
    Case other = c;
    other.recording = without_cell(c.recording, cell);
    const RigParameters change = other.solve().frames.front().theta - all.frames.front().theta;
    const RigParameters step = covariance * score.pull;
    const RigParameters told =
        -solve_symmetric(information - score.information, VectorXd(information * step));
    wrong += nees(change - told, covariance);
    first_order += nees(change + step, covariance);
    moved += nees(change, covariance);
  }
  // The shares of the cells are those with the poses known, which they are not quite.
  EXPECT_LT(wrong, 0.25 * moved);
  EXPECT_LT(wrong, first_order);
  EXPECT_GT(moved, 1.0);
}

TEST(Smoother, RefusesWhatDoesNotFitTogether) {
  Case c(small_scenario(), MotionModel::kImu, 5);
  c.start.pop_back();
  EXPECT_THROW((void)c.solve(), std::invalid_argument);
  Case without(small_scenario(), MotionModel::kImu, 5);
  without.recording.imu.clear();
  EXPECT_THROW((void)without.solve(), std::invalid_argument);
}

}  // namespace
}  // namespace limber
