// SPDX-License-Identifier: MIT
#include "limber/stack/linearization_point.hpp"

#include <gtest/gtest.h>

#include "check_covariance.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/so3.hpp"
#include "limber/navigate/method.hpp"
#include "state/small_map.hpp"

namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::Generator;

const PixelNoise kSigma = PixelNoise::Constant(0.5);

StereoCalibration calibration() {
  StereoCalibration out;
  out.cam0 = out.cam1 = {455.0, 455.0, 376.0, 240.0, 752, 480, NoDistortion{}};
  out.theta << 0.01, -0.02, 0.005, -0.3, 0.003, -0.006;
  out.T_body_cam0 = {so3_exp(Vector3d(-1.2, 1.2, -1.2)), Vector3d(0.05, 0.02, -0.03)};
  return out;
}

RigParameters wrong() { return (RigParameters() << 0.002, -0.004, 0.003, 0.02, -0.006, 0.004).finished(); }

/// A well-known map of `count` points between the depths, and the frame that a rig with the true theta sees.
struct Setting {
  Estimate estimate;
  StereoFrame frame;
};

Setting make(Generator& generator, const RigParameters& theta_true, double near, double far, int count = 40) {
  const StereoCalibration rig = calibration();
  NavigationState nav;
  nav.T_world_body = testing::random_pose(generator, 3.0);
  Setting out{Estimate({MotionModel::kOdometry, false}, nav, 1e-12 * MatrixXd::Identity(6, 6), rig.theta, {}),
              {}};
  for (int k = 0; k < count; ++k) {
    const double depth = testing::random_scalar(generator, near, far);
    const Vector3d X = depth * Vector3d(testing::random_scalar(generator, -0.6, 0.6),
                                        testing::random_scalar(generator, -0.4, 0.4), 1.0);
    Landmark landmark;
    landmark.track_id = k;
    landmark.kind = LandmarkKind::kCartesian;
    landmark.value = nav.T_world_body * (rig.T_body_cam0 * X);
    out.estimate.add_landmark(landmark, 1e-10 * Eigen::Matrix3d::Identity());
    StereoObservation o;
    o.track_id = k;
    o.uv_cam0 = project(rig.cam0, X)->uv;
    o.uv_cam1 = project(rig.cam1, pose_from_rig(theta_true) * X)->uv;
    out.frame.observations.push_back(o);
  }
  return out;
}

MatrixXd all_doubted() { return (kWidestErrors * plausible_error(0.3)).asDiagonal(); }

/// A rig's right camera where theta is off what is assumed.
CameraOff off_theta(const StereoCalibration& rig) {
  return [rig](const VectorXd& off) {
    StereoCalibration moved = rig;
    moved.theta += off.head<6>();
    return mount(moved)[1];
  };
}

/// The rig at which a frame is linearised that F leaves in doubt.
RigParameters found(const Setting& s, const MatrixXd& F = all_doubted()) {
  return calibration().theta + linearization_point(s.estimate, s.frame, off_theta(calibration()), kSigma, F);
}

/// In units of one plausible error.
double distance(const RigParameters& a, const RigParameters& b) {
  return (a - b).cwiseQuotient(plausible_error(calibration().baseline())).cwiseAbs().maxCoeff();
}

TEST(LinearizationPoint, OfAnExactRigIsWhatIsAssumed) {
  Generator generator(1);
  EXPECT_LE(distance(found(make(generator, calibration().theta, 2.0, 20.0)), calibration().theta), 1e-6);
}

TEST(LinearizationPoint, FindsMostOfAnError) {
  Generator generator(2);
  const RigParameters theta_true = calibration().theta + wrong();
  const double before = distance(calibration().theta, theta_true);
  EXPECT_GT(before, 2.0);
  EXPECT_LE(distance(found(make(generator, theta_true, 2.0, 20.0)), theta_true), 0.1 * before);
}

/// In one step these came out as 10 degrees and a baseline that points 40 degrees aside: no pixel is linear
/// in that.
TEST(LinearizationPoint, IsExactWhereAStepIsTooLongForOne) {
  Generator generator(12);
  for (const double degrees : {-10.0, -5.0, 5.0, 10.0}) {
    RigParameters theta_true = calibration().theta;
    theta_true[1] += degrees / kToDegrees;
    const RigParameters off = found(make(generator, theta_true, 2.0, 20.0)) - theta_true;
    EXPECT_LE(off.head<3>().norm() * kToDegrees, 0.01) << degrees;
    EXPECT_LE(off.tail<3>().norm(), 0.01 * calibration().baseline()) << degrees;
  }
}

TEST(LinearizationPoint, IsNotTakenInByAFewOutliers) {
  Generator generator(3);
  const RigParameters theta_true = calibration().theta + wrong();
  Setting s = make(generator, theta_true, 2.0, 20.0, 60);
  for (std::size_t k = 0; k < 5; ++k) {
    s.frame.observations[k].uv_cam1 += Vector2d(20.0, -30.0);
  }
  EXPECT_LE(distance(found(s), theta_true), 0.25 * distance(calibration().theta, theta_true));
}

TEST(LinearizationPoint, WithoutKnownRightPixelsStaysWhereItIs) {
  Generator generator(4);
  const RigParameters theta_true = calibration().theta + wrong();
  Setting unknown = make(generator, theta_true, 2.0, 20.0);
  for (StereoObservation& o : unknown.frame.observations) {
    o.track_id += 1000;
  }
  EXPECT_EQ(found(unknown), calibration().theta);
  Setting left_only = make(generator, theta_true, 2.0, 20.0);
  for (StereoObservation& o : left_only.frame.observations) {
    o.in_cam1 = false;
  }
  EXPECT_EQ(found(left_only), calibration().theta);
  Setting empty = make(generator, theta_true, 2.0, 20.0);
  empty.frame.observations.clear();
  EXPECT_EQ(found(empty), calibration().theta);
}

TEST(LinearizationPoint, FarPointsDoNotMoveTheTranslation) {
  Generator generator(5);
  Setting s = make(generator, calibration().theta, 1e6, 2e6);
  for (StereoObservation& o : s.frame.observations) {
    o.uv_cam1 += 0.5 * testing::random_normal(generator, 2);
  }
  const RigParameters theta = found(s);
  EXPECT_LE((theta - calibration().theta).tail<3>().norm(), 1e-3 * calibration().baseline());
}

TEST(LinearizationPoint, LeavesWhatIsTrustedAsItIs) {
  Generator generator(9);
  const Setting s = make(generator, calibration().theta + wrong(), 3.0, 20.0);
  const StereoCalibration rig = calibration();
  const RigParameters widest = kWidestErrors * plausible_error(rig.baseline());
  const MatrixXd rotation = MatrixXd(widest.asDiagonal()).leftCols<3>();
  const RigParameters theta = found(s, rotation);
  EXPECT_EQ(theta.tail<3>(), rig.theta.tail<3>());
  EXPECT_GE((theta - rig.theta).head<3>().norm(), 1e-3);
  const Eigen::Vector3d along = rig.theta.tail<3>().normalized(), across = along.unitOrthogonal();
  MatrixXd direction = MatrixXd::Zero(6, 5);
  direction.leftCols<3>() = rotation;
  direction.block<3, 1>(3, 3) = widest(3) * across;
  direction.block<3, 1>(3, 4) = widest(3) * along.cross(across);
  const RigParameters moved = found(s, direction) - rig.theta;
  EXPECT_NEAR(moved.tail<3>().dot(rig.theta.tail<3>()), 0.0, 1e-12);
  EXPECT_EQ(found(s, MatrixXd(6, 0)), rig.theta);
}

TEST(LinearizationPoint, FindsWhatElseIsWrongWithTheRightCamera) {
  Generator generator(10);
  ParameterVector error = ParameterVector::Zero();
  error.segment<5>(first_of(ParameterBlock::kCam1)) << 4.0, -3.0, 5.0, 6.0, 0.02;
  const StereoCalibration assumed = corrected(calibration(), error);
  const Setting s = make(generator, calibration().theta, 2.0, 20.0, 60);
  const CameraOff cam1 = [&](const VectorXd& off) {
    MountedCamera out = mount(corrected(assumed, off))[1];
    out.with_parameters = true;
    return out;
  };
  MatrixXd F = MatrixXd::Zero(kParameters, 5);
  F.middleRows<5>(first_of(ParameterBlock::kCam1)) =
      (kWidestErrors * plausible_errors(assumed).segment<5>(first_of(ParameterBlock::kCam1))).asDiagonal();
  const VectorXd shift = linearization_point(s.estimate, s.frame, cam1, kSigma, F);
  EXPECT_LE((shift + error).cwiseQuotient(plausible_errors(assumed)).cwiseAbs().maxCoeff(), 0.05);
}

}  // namespace
}  // namespace limber
