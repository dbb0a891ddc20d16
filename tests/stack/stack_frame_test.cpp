// SPDX-License-Identifier: MIT
#include "limber/stack/stack_frame.hpp"

#include <gtest/gtest.h>

#include <random>

#include "check_jacobian.hpp"
#include "limber/core/so3.hpp"
#include "state/small_map.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::Generator;

const PixelNoise kUnequalSigma(0.4, 0.5, 0.6, 0.7);

StereoCalibration calibration(BodyFrame body) {
  StereoCalibration out;
  out.cam0 = {455.0, 450.0, 376.0, 240.0, 752, 480, NoDistortion{}};
  out.cam1 = {460.0, 458.0, 370.0, 250.0, 752, 480, NoDistortion{}};
  out.theta << 0.01, -0.02, 0.005, -0.3, 0.003, -0.006;
  out.body = body;
  out.T_body_cam0 = {so3_exp(Vector3d(-1.2, 1.2, -1.2)), Vector3d(0.05, 0.02, -0.03)};
  return out;
}

/// Landmarks 0 to 5 before the cameras, of both kinds in turn; the inverse-depth ones on two anchors.
Estimate visible_map(Generator& generator, const StateLayout& layout, const StereoCalibration& rig) {
  Estimate estimate = testing::random_estimate(generator, layout);
  estimate.assume_theta(rig.theta);
  const Pose here = estimate.nav().T_world_body;
  for (int k = 0; k < 6; ++k) {
    const Vector3d X_cam0(0.4 * k - 1.0, 0.3 - 0.1 * k, 4.0 + k);
    if (k % 2 == 0) {
      testing::add_random_landmark(generator, estimate, k, -1);
      estimate.find(k)->value = here * (body_from_cam0(rig) * X_cam0);
    } else {
      testing::move_body(estimate, [&](NavigationState& nav) {
        nav.T_world_body.p = here.p + 0.1 * testing::random_vector(generator, 1.0);
      });
      testing::add_random_landmark(generator, estimate, k, estimate.add_anchor(body_from_cam0(rig)));
      Landmark& landmark = *estimate.find(k);
      landmark.R_cam0_chart = rotation_between(Vector3d::UnitZ(), X_cam0.normalized());
      landmark.value << 0.01, -0.02, 1.0 / X_cam0.norm();
      testing::move_body(estimate, [&](NavigationState& nav) { nav.T_world_body = here; });
    }
  }
  return estimate;
}

/// What the rig sees of the map, but for `offset` [px] in every coordinate.
StereoFrame perfect_frame(const Estimate& estimate, const MountedRig& rig, double offset = 0.0) {
  StereoFrame frame;
  for (std::int64_t id = 0; id < 6; ++id) {
    const Landmark& landmark = *estimate.find(id);
    const auto pixel = [&](const MountedCamera& camera) {
      return Vector2d(project_point(camera, body_point_at_exposure(camera, estimate.nav().T_world_body,
                                                                   landmark, estimate.anchor_of(landmark)))
                          ->uv +
                      Vector2d::Constant(offset));
    };
    StereoObservation observation;
    observation.track_id = id;
    observation.uv_cam0 = pixel(rig[0]);
    observation.uv_cam1 = pixel(rig[1]);
    frame.observations.push_back(observation);
  }
  return frame;
}

struct Stacked {
  StackedFrame frame;
  std::vector<Refusal> refused;
};

Stacked stacked(const Estimate& estimate, const StereoFrame& frame, const MountedRig& rig,
                const std::unordered_map<std::int64_t, RemainingRows>& new_landmarks = {}) {
  Stacked out;
  out.frame = stack_frame(estimate, frame, rig, kUnequalSigma, new_landmarks, out.refused);
  return out;
}

TEST(StackFrame, ResidualIsWhatThePixelsAreOff) {
  Generator generator(1);
  const StereoCalibration rig = calibration(BodyFrame::kImu);
  const Estimate estimate = visible_map(generator, {MotionModel::kImu, false}, rig);
  const Stacked z = stacked(estimate, perfect_frame(estimate, mount(rig), 2.0), mount(rig));
  ASSERT_EQ(z.frame.measurement.rows(), 24);
  EXPECT_LE((z.frame.measurement.residual - VectorXd::Constant(24, 2.0)).cwiseAbs().maxCoeff(), 1e-10);
  for (Index row = 0; row < 24; row += 4) {
    EXPECT_EQ(z.frame.measurement.sigma.segment<4>(row), kUnequalSigma);
  }
  EXPECT_EQ(z.frame.track_ids, (std::vector<std::int64_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_TRUE(z.refused.empty());
}

/// What the errors in P are when the whole world turns by one radian about the vertical: those of a frozen
/// landmark as it was when its epoch began.
VectorXd turn_of_the_world(const Estimate& now, const Estimate& when_epoch_began) {
  const Vector3d up = Vector3d::UnitZ();
  VectorXd turn = VectorXd::Zero(now.size());
  turn.segment<3>(StateLayout::kPosition) = up.cross(now.nav().T_world_body.p);
  turn.segment<3>(StateLayout::kAttitude) = now.nav().T_world_body.R.transpose() * up;
  for (const Landmark& landmark : now.landmarks()) {
    if (landmark.passive) {
      continue;
    }
    const Landmark& then = *when_epoch_began.find(landmark.track_id);
    if (const Anchor* anchor = when_epoch_began.anchor_of(then); anchor != nullptr) {
      turn.segment<3>(now.anchor_of(landmark)->position_at) = up.cross(anchor->T_world_body.p);
      turn.segment<3>(now.anchor_of(landmark)->attitude_at) = anchor->T_world_body.R.transpose() * up;
    } else {
      turn.segment<3>(landmark.at) = up.cross(then.value);
    }
  }
  return turn;
}

TEST(StackFrame, SeesNoHeadingWhereFrozenLandmarksHaveBeenCorrected) {
  Generator generator(8);
  const StereoCalibration rig = calibration(BodyFrame::kImu);
  Estimate estimate = visible_map(generator, {MotionModel::kImu, false}, rig);
  testing::add_random_landmark(generator, estimate, 6, -1);
  estimate.change_epoch({6});  // the others are frozen
  const Estimate before = estimate;
  std::normal_distribution<double> draw;
  estimate.retract(VectorXd::NullaryExpr(estimate.size(), [&] { return 0.03 * draw(generator); }));
  const VectorXd turn = turn_of_the_world(estimate, before);

  const Stacked z = stacked(estimate, perfect_frame(before, mount(rig)), mount(rig));
  ASSERT_EQ(z.frame.track_ids.size(), 6U);
  const MatrixXd H = z.frame.measurement.H.dense(z.frame.measurement.rows(), estimate.size());
  EXPECT_LE((H * turn).norm(), 1e-9 * H.norm() * turn.norm());
}

/// What the errors in P are when all lengths grow, per unit of the factor's logarithm: those of a frozen
/// landmark as it was when its epoch began.
VectorXd growth_of_all_lengths(const Estimate& now, const Estimate& when_epoch_began) {
  VectorXd g = VectorXd::Zero(now.size());
  g.segment<3>(StateLayout::kPosition) = now.nav().T_world_body.p;
  g.segment<3>(StateLayout::kVelocity) = now.nav().v_world_body;
  g(now.layout().map_scale()) = 1.0;
  for (const Landmark& landmark : now.landmarks()) {
    if (landmark.passive) {
      continue;
    }
    const Landmark& then = *when_epoch_began.find(landmark.track_id);
    if (const Anchor* anchor = when_epoch_began.anchor_of(then); anchor != nullptr) {
      g.segment<3>(now.anchor_of(landmark)->position_at) = anchor->T_world_body.p;
      g(landmark.at + 2) = -then.value.z();
    } else {
      g.segment<3>(landmark.at) = then.value;
    }
  }
  return g;
}

TEST(StackFrame, SeesNoScaleWhereFrozenLandmarksHaveBeenCorrected) {
  Generator generator(9);
  const StereoCalibration rig = calibration(BodyFrame::kCam0);
  StateLayout layout{MotionModel::kImu};
  layout.has_map_scale = true;
  Estimate estimate = visible_map(generator, layout, rig);
  testing::add_random_landmark(generator, estimate, 6, -1);
  estimate.change_epoch({6});  // the others are frozen
  const Estimate before = estimate;
  std::normal_distribution<double> draw;
  estimate.retract(VectorXd::NullaryExpr(estimate.size(), [&] { return 0.02 * draw(generator); }));
  const VectorXd growth = growth_of_all_lengths(estimate, before);

  const Stacked z = stacked(estimate, perfect_frame(before, mount(rig)), mount(rig));
  ASSERT_EQ(z.frame.track_ids.size(), 6U);
  const MatrixXd H = z.frame.measurement.H.dense(z.frame.measurement.rows(), estimate.size());
  // To the right camera all lengths grow as much as its baseline shrinks, which is constrained.
  const VectorXd seen = H * growth + z.frame.measurement.D.rightCols<3>() * rig.theta.tail<3>();
  EXPECT_LE(seen.norm(), 1e-4 * (z.frame.measurement.D.rightCols<3>() * rig.theta.tail<3>()).norm());
}

/// Minus the derivative of the residual with respect to the error state (by retraction) and theta.
TEST(StackFrame, HAndDMatchCentralDifferencesOfTheRetractedEstimate) {
  Generator generator(2);
  for (const BodyFrame body : {BodyFrame::kImu, BodyFrame::kMiddleOfBaseline}) {
    for (const bool has_theta : {false, true}) {
      StereoCalibration rig = calibration(body);
      const Estimate estimate = visible_map(generator, {MotionModel::kImu, has_theta}, rig);
      const StereoFrame frame = perfect_frame(estimate, mount(rig));
      const LinearMeasurement z = stacked(estimate, frame, mount(rig)).frame.measurement;
      const auto residual = [&](const VectorXd& dx, const VectorXd& dtheta) {
        Estimate moved = estimate;
        moved.retract(dx);
        StereoCalibration moved_rig = rig;
        moved_rig.theta = moved.theta() + dtheta;
        return VectorXd(-stacked(moved, frame, mount(moved_rig)).frame.measurement.residual);
      };
      const VectorXd no_dx = VectorXd::Zero(estimate.size());
      testing::check_jacobian(
          z.H.dense(z.rows(), estimate.size()),
          [&](const VectorXd& dx) { return residual(dx, VectorXd::Zero(6)); }, 1e-6);
      ASSERT_EQ(z.D.cols(), 6);
      testing::check_jacobian(
          z.D, [&](const VectorXd& dtheta) { return residual(no_dx, dtheta); }, 1e-6);
    }
  }
}

/// The cameras of `rig`, corrected by what the estimate says, on a body that moves as it says.
MountedRig mounted_on(const Estimate& estimate, const StereoCalibration& rig, const Vector3d& gyro,
                      const ParameterVector& error) {
  ParameterVector more = error;
  more.tail<kMoreParameters>() += estimate.more();
  StereoCalibration corrected_rig = corrected(rig, more);
  corrected_rig.theta = estimate.theta() + error.head<6>();
  MountedRig out = mount(corrected_rig);
  for (MountedCamera& camera : out) {
    camera.with_parameters = true;
    camera.motion.v_world = estimate.nav().v_world_body;
    camera.motion.omega_body = estimate.layout().motion == MotionModel::kImu
                                   ? Vector3d(gyro - estimate.nav().bias_gyro)
                                   : estimate.nav().omega_body;
  }
  return out;
}

TEST(StackFrame, HAndDOfAllParametersMatchCentralDifferencesOfTheRetractedEstimate) {
  Generator generator(12);
  const Vector3d gyro(0.3, -0.8, 1.1);
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    for (const double offset : {0.0, 0.006}) {
      SCOPED_TRACE(::testing::Message() << "motion " << static_cast<int>(motion) << ", offset " << offset);
      StereoCalibration rig = calibration(BodyFrame::kImu);
      rig.time_offset_s = {offset, -0.5 * offset};
      StateLayout layout{motion, true};
      layout.has_more = {true, true, true};
      Estimate estimate = visible_map(generator, layout, rig);
      testing::move_body(estimate, [&](NavigationState& nav) { nav.v_world_body << 1.5, -2.0, 0.4; });
      testing::move_body(estimate, [&](NavigationState& nav) { nav.omega_body << -0.4, 0.9, 0.2; });
      const MountedRig here = mounted_on(estimate, rig, gyro, ParameterVector::Zero());
      const StereoFrame frame = perfect_frame(estimate, here);
      const LinearMeasurement z = stacked(estimate, frame, here).frame.measurement;
      const auto residual = [&](const VectorXd& dx, const ParameterVector& error) {
        Estimate moved = estimate;
        moved.retract(dx);
        return VectorXd(
            -stacked(moved, frame, mounted_on(moved, rig, gyro, error)).frame.measurement.residual);
      };
      testing::check_jacobian(
          z.H.dense(z.rows(), estimate.size()),
          [&](const VectorXd& dx) { return residual(dx, ParameterVector::Zero()); }, 1e-6);
      ASSERT_EQ(z.D.cols(), kParameters);
      const VectorXd no_dx = VectorXd::Zero(estimate.size());
      testing::check_jacobian(
          z.D, [&](const VectorXd& error) { return residual(no_dx, error); }, 1e-6);
    }
  }
}

TEST(StackFrame, AParameterThatACameraDoesNotHaveMovesNoneOfItsPixels) {
  Generator generator(13);
  const StereoCalibration rig = calibration(BodyFrame::kImu);
  const Estimate estimate = visible_map(generator, {MotionModel::kOdometry, false}, rig);
  const MountedRig here = mounted_on(estimate, rig, Vector3d::Zero(), ParameterVector::Zero());
  const LinearMeasurement z = stacked(estimate, perfect_frame(estimate, here), here).frame.measurement;
  for (Index row = 0; row < z.rows(); row += 4) {
    EXPECT_TRUE(z.D.block(row, first_of(ParameterBlock::kCam1), 2, 6).isZero(0.0));
    EXPECT_TRUE(z.D.block(row + 2, first_of(ParameterBlock::kCam0), 2, 6).isZero(0.0));
    EXPECT_FALSE(z.D.block(row, first_of(ParameterBlock::kCam0), 2, 5).isZero(1e-3));
    EXPECT_FALSE(z.D.block(row + 2, first_of(ParameterBlock::kMount), 2, 6).isZero(1e-3));
  }
}

TEST(StackFrame, EachCameraThatSawThePointGivesTwoRows) {
  Generator generator(3);
  const StereoCalibration rig = calibration(BodyFrame::kImu);
  const Estimate estimate = visible_map(generator, {MotionModel::kImu, false}, rig);
  StereoFrame frame = perfect_frame(estimate, mount(rig));
  frame.observations[1].in_cam1 = false;
  frame.observations[2].in_cam0 = false;
  frame.observations[3].in_cam0 = frame.observations[3].in_cam1 = false;
  frame.observations[4].track_id = 99;  // not in the map
  const Stacked z = stacked(estimate, frame, mount(rig));
  EXPECT_EQ(z.frame.track_ids, (std::vector<std::int64_t>{0, 1, 2, 5}));
  ASSERT_EQ(z.frame.measurement.groups.size(), 4U);
  Index row = 0;
  for (std::size_t g = 0; g < 4; ++g) {
    EXPECT_EQ(z.frame.measurement.groups[g].row, row);
    row += z.frame.measurement.groups[g].rows;
  }
  EXPECT_EQ(row, 4 + 2 + 2 + 4);
  EXPECT_EQ(row, z.frame.measurement.rows());
  EXPECT_EQ(z.frame.measurement.sigma.segment<2>(4), kUnequalSigma.head<2>());
  EXPECT_EQ(z.frame.measurement.sigma.segment<2>(6), kUnequalSigma.tail<2>());
  // Left rows do not depend on theta, right ones do.
  EXPECT_TRUE(z.frame.measurement.D.middleRows<2>(4).isZero(0.0));
  EXPECT_FALSE(z.frame.measurement.D.middleRows<2>(6).isZero(1.0));
}

TEST(StackFrame, OfANewLandmarkOnlyTheRowsItsInitializationLeft) {
  Generator generator(4);
  const StereoCalibration rig = calibration(BodyFrame::kImu);
  const Estimate estimate = visible_map(generator, {MotionModel::kImu, false}, rig);
  const StereoFrame frame = perfect_frame(estimate, mount(rig));
  const Stacked z =
      stacked(estimate, frame, mount(rig),
              {{0, RemainingRows::kNone}, {1, RemainingRows::kRight}, {2, RemainingRows::kAll}});
  EXPECT_EQ(z.frame.track_ids, (std::vector<std::int64_t>{1, 2, 3, 4, 5}));
  EXPECT_EQ(z.frame.measurement.groups[0].rows, 2);
  EXPECT_EQ(z.frame.measurement.sigma.head<2>(), kUnequalSigma.tail<2>());
  EXPECT_EQ(z.frame.measurement.groups[1].rows, 4);
}

TEST(StackFrame, RefusesPointsThatDoNotProjectIntoACameraThatSawThem) {
  Generator generator(5);
  const StereoCalibration rig = calibration(BodyFrame::kImu);
  Estimate estimate = visible_map(generator, {MotionModel::kImu, false}, rig);
  const StereoFrame frame = perfect_frame(estimate, mount(rig));
  const Pose T_world_cam0 = estimate.nav().T_world_body * body_from_cam0(rig);
  estimate.find(2)->value = T_world_cam0 * Vector3d(0.0, 0.0, -3.0);
  const Stacked z = stacked(estimate, frame, mount(rig));
  ASSERT_EQ(z.refused.size(), 1U);
  EXPECT_EQ(z.refused[0].track_id, 2);
  EXPECT_EQ(z.refused[0].reason, RefusalReason::kNotProjectable);
  EXPECT_EQ(z.frame.track_ids, (std::vector<std::int64_t>{0, 1, 3, 4, 5}));
}

TEST(StackFrame, AnEmptyFrameMakesAnEmptyMeasurement) {
  Generator generator(6);
  const StereoCalibration rig = calibration(BodyFrame::kImu);
  const Estimate estimate = visible_map(generator, {MotionModel::kImu, false}, rig);
  const Stacked z = stacked(estimate, {}, mount(rig));
  EXPECT_EQ(z.frame.measurement.rows(), 0);
  EXPECT_TRUE(z.frame.track_ids.empty());
}

}  // namespace
}  // namespace limber
