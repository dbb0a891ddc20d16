// SPDX-License-Identifier: MIT
// What can be said of a calibration without a filter: depth and mistakes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "limber/datasets/read_recording.hpp"
#include "limber/diagnose/calibration_mistakes.hpp"
#include "limber/diagnose/depth_effect.hpp"
#include "real_data.hpp"
#include "run/short_recording.hpp"
#include "shipped_scenario.hpp"

namespace limber {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kDegree = std::numbers::pi / 180.0;

RigParameters side_by_side(double baseline) { return -baseline * RigParameters::Unit(3); }

TEST(DepthError, OfAParallelRigIsThatOfDisparityOverFocalLength) {
  // Z = B / d with d = B / z, in units of the focal length; a true baseline 1 % longer makes d 1 % larger.
  const RigParameters assumed = side_by_side(0.2);
  EXPECT_NEAR(depth_error(assumed, -0.002 * RigParameters::Unit(3), 10.0).value(), 10.0 / 1.01 - 10.0, 1e-9);
  // A turn by phi about y moves the right point by tan(phi (1 + ...)): to first order z²/B phi.
  const double phi = 1e-5;
  EXPECT_NEAR(std::abs(depth_error(assumed, phi * RigParameters::Unit(1), 10.0).value()), 500.0 * phi, 5e-5);
  EXPECT_NEAR(depth_error(assumed, RigParameters::Zero(), 10.0).value(), 0.0, 1e-9);
}

TEST(DepthError, IsUnknownWhereTheRaysNoLongerMeetInFront) {
  const RigParameters assumed = side_by_side(0.2);
  const auto error = [&](double angle) { return depth_error(assumed, angle * RigParameters::Unit(1), 20.0); };
  EXPECT_NE(error(2.0 * kDegree).has_value(), error(-2.0 * kDegree).has_value());
}

TEST(DepthEffects, GiveSigmaFromThatOfTheOffset) {
  RigEstimate offset;
  offset.covariance(3, 3) = 0.002 * 0.002;  // 1 % of the baseline: 1 % of the depth
  const std::vector<DepthEffect> effects = depth_effects(side_by_side(0.2), offset, true);
  ASSERT_EQ(effects.size(), 3u);
  EXPECT_EQ(effects[1].depth, 10.0);
  EXPECT_NEAR(effects[1].error.value(), 0.0, 1e-9);
  EXPECT_NEAR(effects[1].sigma, 0.1, 1e-6);
}

TEST(DepthEffects, TrustTheLengthOfTheBaselineWhereNothingShowsAMetre) {
  RigEstimate offset;
  offset.delta = 0.001 * RigParameters::Unit(1) + 0.05 * RigParameters::Unit(3);
  offset.covariance(3, 3) = 0.1 * 0.1;
  const std::vector<DepthEffect> effects = depth_effects(side_by_side(0.2), offset, false);
  EXPECT_DOUBLE_EQ(effects[1].error.value(),
                   depth_error(side_by_side(0.2), 0.001 * RigParameters::Unit(1), 10.0).value());
  EXPECT_NEAR(effects[1].sigma, 0.0, 1e-9);
}

/// A short simulated recording with a sound rig.
Recording sound_recording() {
  Scenario scenario = testing::short_scenario();
  scenario.decalibration.clear();
  return simulate(scenario, 1);
}

std::vector<StereoFrame> swapped(std::vector<StereoFrame> frames) {
  for (StereoFrame& frame : frames) {
    for (StereoObservation& o : frame.observations) {
      std::swap(o.uv_cam0, o.uv_cam1);
      std::swap(o.in_cam0, o.in_cam1);
    }
  }
  return frames;
}

TEST(CalibrationMistakes, NameLengthsInMillimetres) {
  Recording recording = sound_recording();
  recording.calibration.theta.tail<3>() *= 1000.0;
  recording.calibration.T_body_cam0.p *= 1000.0;
  EXPECT_THAT(calibration_mistakes(recording.calibration, recording.frames),
              ElementsAre(HasSubstr("is the calibration in mm")));
  EXPECT_THAT(placement_mistake(recording.calibration, recording.frames).value_or(""),
              HasSubstr("metres are expected"));
}

TEST(CalibrationMistakes, AreNoneInASoundRigOrOneThatIsOffByTheUsual) {
  const Recording sound = sound_recording();
  EXPECT_THAT(calibration_mistakes(sound.calibration, sound.frames), IsEmpty());
  const Recording off = testing::short_recording();
  EXPECT_THAT(calibration_mistakes(off.calibration, off.frames), IsEmpty());
}

TEST(CalibrationMistakes, NameSwappedCameras) {
  const Recording recording = sound_recording();
  EXPECT_THAT(calibration_mistakes(recording.calibration, swapped(recording.frames)),
              ElementsAre(HasSubstr("the two cameras are swapped")));
}

/// Each pixel then went through the other camera's lens, and the rig the other way round fits no line,
/// either.
TEST(CalibrationMistakes, NameSwappedCamerasWhoseIntrinsicsDiffer) {
  Scenario scenario = testing::short_scenario();
  scenario.decalibration.clear();
  scenario.rig.cam1.cu += 13.0;
  scenario.rig.cam1.cv -= 11.0;
  scenario.rig.cam1.fv = scenario.rig.cam1.fu = 297.0;
  const Recording recording = simulate(scenario, 1);
  EXPECT_THAT(calibration_mistakes(recording.calibration, recording.frames), IsEmpty());
  EXPECT_THAT(calibration_mistakes(recording.calibration, swapped(recording.frames)),
              ElementsAre(HasSubstr("the two cameras are swapped")));
}

/// A car's points, far and near, whose right camera has turned by `vergence`.
std::vector<StereoFrame> street(const StereoCalibration& calibration, double vergence) {
  StereoCalibration turned = calibration;
  turned.theta(1) += vergence;
  const Pose T_cam1_cam0 = pose_from_rig(turned.theta);
  StereoFrame frame;
  for (int i = 0; i < 400; ++i) {
    const double z = 4.0 * std::pow(40.0, (i % 20) / 19.0);
    const Eigen::Vector3d X(z * (-0.6 + 1.2 * ((7 * i) % 23) / 22.0),
                            z * (-0.3 + 0.6 * ((5 * i) % 19) / 18.0), z);
    const Eigen::Vector3d right = T_cam1_cam0 * X;
    StereoObservation o;
    o.track_id = i;
    o.uv_cam0 = project(calibration.cam0, X).value().uv;
    o.uv_cam1 = project(calibration.cam1, right).value().uv;
    o.in_cam0 = o.in_cam1 = true;
    frame.observations.push_back(o);
  }
  return {frame};
}

/// Lines that pixels make through the wrong lens turn the rig by degrees, and that puts far points on either
/// side.
TEST(CalibrationMistakes, NameSwappedCamerasWhoseLensesDiffer) {
  StereoCalibration rig = sound_recording().calibration;
  rig.theta << 0.005, -0.009, -0.006, -0.5, 0.004, 0.002;
  rig.cam0 = {688.0, 686.0, 650.0, 352.0, 1280, 720, RadialTangential{-0.12, 0.04, 3e-4, -2e-4}};
  rig.cam1 = {683.0, 684.0, 637.0, 367.0, 1280, 720, RadialTangential{-0.26, 0.06, -3e-4, 1e-4}};
  for (const double degrees : {-0.2, 0.0, 0.2}) {
    const std::vector<StereoFrame> frames = street(rig, degrees * kDegree);
    EXPECT_FALSE(placement_mistake(rig, frames)) << degrees;
    EXPECT_THAT(placement_mistake(rig, swapped(frames)).value_or(""),
                HasSubstr("the two cameras are swapped"))
        << degrees;
  }
}

/// Vergence puts points behind the rig, as a baseline of the wrong sign does: the epipolar lines know which.
TEST(CalibrationMistakes, TakeARigThatHasTurnedForNoWrongBaseline) {
  StereoCalibration rig = sound_recording().calibration;
  rig.theta = side_by_side(0.5);
  StereoCalibration wrong = rig;
  wrong.theta = -rig.theta;
  for (const double degrees : {-5.0, -3.0, -2.0, -1.0, 0.0, 1.0, 3.0, 5.0}) {
    EXPECT_FALSE(placement_mistake(rig, street(rig, degrees * kDegree))) << degrees;
  }
  for (const double degrees : {-0.3, 0.0, 0.3}) {
    EXPECT_TRUE(placement_mistake(wrong, street(rig, degrees * kDegree))) << degrees;
  }
}

/// Cars' rigs off by degrees were called a baseline of the wrong sign, or a wrong lens.
TEST(CalibrationMistakes, AreNoneInRealRigsThatHaveTurnedByDegrees) {
  LIMBER_NEED_DATA(folder, "track_logs");
  for (const char* const name : {"kitti_09_26_drive_0036", "kitti_09_30_drive_0020"}) {
    const Recording drive = read_recording(folder / name);
    for (const double degrees : {-5.0, -3.0, 2.0}) {
      for (const Eigen::Index axis : {0, 1, 2}) {
        StereoCalibration off = drive.calibration;
        off.theta(axis) += degrees * kDegree;
        EXPECT_THAT(calibration_mistakes(off, drive.frames), IsEmpty())
            << name << ' ' << axis << ' ' << degrees;
      }
    }
  }
}

/// Most points of this flight are so far that they agree whichever way the baseline points.
TEST(CalibrationMistakes, NameWhatNearPointsAloneCanTell) {
  const Recording recording = simulate(testing::shipped("drone_moving"), 3);
  const StereoCalibration& rig = recording.calibration;
  const Pose T_imu_cam1 = rig.T_body_cam0 * pose_from_rig(rig.theta).inverse();
  StereoCalibration wrong = rig;
  wrong.T_body_cam0 = rig.T_body_cam0.inverse();
  wrong.theta = rig_from_pose(T_imu_cam1 * wrong.T_body_cam0);
  EXPECT_FALSE(placement_mistake(rig, recording.frames));
  const auto mistake = placement_mistake(wrong, recording.frames);
  ASSERT_TRUE(mistake);
  EXPECT_THAT(*mistake, HasSubstr("T_BS of both cameras is inverted"));
}

TEST(CalibrationMistakes, NameATransformThatIsInverted) {
  const Recording recording = sound_recording();
  // A camera that looks along the IMU's x axis, as on many rigs; then T_BS of cam1 is written the wrong way
  // round.
  StereoCalibration calibration = recording.calibration;
  calibration.body = BodyFrame::kImu;
  calibration.T_body_cam0.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  calibration.T_body_cam0.p = {0.1, 0.05, -0.02};
  const Pose T_imu_cam1 = calibration.T_body_cam0 * pose_from_rig(calibration.theta).inverse();
  StereoCalibration wrong = calibration;
  wrong.theta = rig_from_pose(T_imu_cam1 * calibration.T_body_cam0);
  EXPECT_THAT(calibration_mistakes(calibration, recording.frames), IsEmpty());
  EXPECT_THAT(calibration_mistakes(wrong, recording.frames),
              ElementsAre(HasSubstr("T_BS of cam1 is inverted")));
}

TEST(CalibrationMistakes, NameAWrongResolution) {
  const Recording recording = sound_recording();
  StereoCalibration half = recording.calibration;
  for (Camera* const camera : {&half.cam0, &half.cam1}) {
    camera->width /= 2;
    camera->height /= 2;
  }
  const auto mistakes = calibration_mistakes(half, recording.frames);
  EXPECT_THAT(mistakes, ::testing::Contains(HasSubstr("principal point of cam0")));
  EXPECT_THAT(mistakes, ::testing::Contains(HasSubstr("of the points of cam0 lie outside its")));
  StereoCalibration twice = recording.calibration;
  twice.cam1.width *= 2;
  twice.cam1.height *= 2;
  EXPECT_THAT(calibration_mistakes(twice, recording.frames),
              ::testing::Contains(HasSubstr("no point of cam1 lies beyond")));
}

/// A drone: it turns, and with that shows its lens.
Recording flight(const Distortion& distortion) {
  Scenario scenario = testing::shipped("drone_none", 10.0);
  scenario.rig.cam0.distortion = scenario.rig.cam1.distortion = distortion;
  return simulate(scenario, 2);
}

void set_distortion(Recording& recording, const Distortion& distortion) {
  recording.calibration.cam0.distortion = recording.calibration.cam1.distortion = distortion;
}

/// Motions fit them with a distortion only, and that is not what is wrong.
TEST(CalibrationMistakes, TakeIntrinsicsOfHalfTheResolutionForNothingElse) {
  Recording recording = flight({});
  for (Camera* const camera : {&recording.calibration.cam0, &recording.calibration.cam1}) {
    camera->fu /= 2;
    camera->fv /= 2;
    camera->cu /= 2;
    camera->cv /= 2;
  }
  EXPECT_THAT(calibration_mistakes(recording.calibration, recording.frames),
              ElementsAre(HasSubstr("principal point of cam0"), HasSubstr("principal point of cam1")));
}

TEST(CalibrationMistakes, NameRectifiedImagesWithARawCalibrationAndTheReverse) {
  const RadialTangential lens{-0.28, 0.07, 0.0, 0.0};
  Recording rectified = flight(NoDistortion{}), raw = flight(lens);
  EXPECT_THAT(calibration_mistakes(rectified.calibration, rectified.frames), IsEmpty());
  EXPECT_THAT(calibration_mistakes(raw.calibration, raw.frames), IsEmpty());
  set_distortion(rectified, lens);
  EXPECT_THAT(calibration_mistakes(rectified.calibration, rectified.frames),
              ElementsAre(HasSubstr("the images look rectified")));
  set_distortion(raw, NoDistortion{});
  EXPECT_THAT(calibration_mistakes(raw.calibration, raw.frames),
              ElementsAre(HasSubstr("the images look raw")));
}

/// A tracker that judges by the wrong lens drops the points that the lens bends most; those that are left fit
/// a motion to half a pixel.
TEST(CalibrationMistakes, NameRawImagesOfWhichTheTrackerKeptTheMiddle) {
  Recording raw = flight(RadialTangential{-0.28, 0.07, 0.0, 0.0});
  set_distortion(raw, NoDistortion{});
  const Camera& camera = raw.calibration.cam0;
  for (StereoFrame& frame : raw.frames) {
    std::erase_if(frame.observations, [&](const StereoObservation& o) {
      return (o.uv_cam0 - Eigen::Vector2d(camera.cu, camera.cv)).norm() > 0.4 * camera.fu;
    });
  }
  EXPECT_THAT(calibration_mistakes(raw.calibration, raw.frames),
              ElementsAre(HasSubstr("the images look raw")));
}

TEST(CalibrationMistakes, NameRawImagesOfARealRigAndOfOneThatHasTurned) {
  LIMBER_NEED_DATA(folder, "track_logs");
  Recording raw = read_recording(folder / "euroc_imu_april");
  set_distortion(raw, NoDistortion{});
  for (const double degrees : {0.0, -2.0}) {
    StereoCalibration off = raw.calibration;
    off.theta(1) += degrees * kDegree;
    EXPECT_THAT(calibration_mistakes(off, raw.frames), ElementsAre(HasSubstr("the images look raw")))
        << degrees;
  }
}

/// A car hardly turns: no pair of frames tells a lens, all of them together do. Both ways, for rigs as they
/// are and bent ones.
TEST(CalibrationMistakes, NameRectifiedImagesOfACar) {
  LIMBER_NEED_DATA(folder, "track_logs");
  Recording car = read_recording(folder / "kitti_09_26_drive_0005");
  StereoCalibration raw = car.calibration;
  raw.cam0.distortion = raw.cam1.distortion = RadialTangential{-0.37, 0.2, 0.0, 0.0};
  for (const double degrees : {0.0, 2.0}) {
    for (StereoCalibration* rig : {&car.calibration, &raw}) {
      rig->theta(1) += degrees * kDegree;
    }
    EXPECT_THAT(calibration_mistakes(car.calibration, car.frames), IsEmpty()) << degrees;
    EXPECT_THAT(calibration_mistakes(raw, car.frames), ElementsAre(HasSubstr("the images look rectified")))
        << degrees;
  }
}

TEST(CalibrationMistakes, AreNoneOfARigThatIsOnlyBent) {
  const RadialTangential lens{-0.28, 0.07, 0.0, 0.0};
  for (const Distortion& distortion : {Distortion(NoDistortion{}), Distortion(lens)}) {
    Recording recording = flight(distortion);
    recording.calibration.theta.head<3>() += Eigen::Vector3d::Constant(2.0 * kDegree);
    EXPECT_THAT(calibration_mistakes(recording.calibration, recording.frames), IsEmpty());
  }
}

}  // namespace
}  // namespace limber
