// SPDX-License-Identifier: MIT
#include "limber/rig_files/write_rig_files.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "datasets/files.hpp"
#include "limber/rig_files/rig_file.hpp"
#include "message_of.hpp"
#include "rig_files/rigs.hpp"

namespace limber {
namespace {

using testing::expect_same_camera;
using testing::expect_same_pose;
using testing::some_rig;

class WrittenRig : public ::testing::TestWithParam<Distortion> {};

TEST_P(WrittenRig, ComesBackFromEveryFormatThatSaysItAll) {
  const testing::TemporaryFolder folder;
  StereoCalibration rig = some_rig(GetParam());
  const auto names = write_rig_files(folder.path(), rig, ImuNoise{});
  for (const char* name : {"", "camchain.yaml", "stereo.yml", "calib_cam_to_cam.txt"}) {
    SCOPED_TRACE(name);
    if (!std::filesystem::exists(folder.path() / name)) {
      EXPECT_TRUE(std::holds_alternative<Equidistant>(GetParam())) << "KITTI alone cannot say it";
      continue;
    }
    const RigFile back = read_rig_file(folder.path() / name, ImageKind::kRaw);
    expect_same_camera(back.calibration.cam0, rig.cam0);
    expect_same_camera(back.calibration.cam1, rig.cam1);
    expect_same_pose(pose_from_rig(back.calibration.theta), pose_from_rig(rig.theta));
    if (back.calibration.body == BodyFrame::kImu) {
      expect_same_pose(back.calibration.T_body_cam0, rig.T_body_cam0);
    }
  }
  const ImuNoise noise = read_kalibr_imu(folder.path() / "imu.yaml");
  EXPECT_EQ(noise.gyro_density, ImuNoise{}.gyro_density);
  EXPECT_EQ(noise.accel_walk, ImuNoise{}.accel_walk);
}

INSTANTIATE_TEST_SUITE_P(Distortions, WrittenRig,
                         ::testing::Values(Distortion{NoDistortion{}},
                                           Distortion{RadialTangential{-0.28, 0.07, 2e-4, 2e-5}},
                                           Distortion{Equidistant{-0.006, 0.03, -0.034, 0.0148}}));

TEST(WriteRigFiles, KalibrKeepsTheTimeOffsets) {
  const testing::TemporaryFolder folder;
  StereoCalibration rig = some_rig();
  rig.time_offset_s = {0.0025, 0.0031};
  static_cast<void>(write_rig_files(folder.path(), rig, std::nullopt));
  EXPECT_EQ(read_rig_file(folder.path() / "camchain.yaml").calibration.time_offset_s, rig.time_offset_s);
}

TEST(WriteRigFiles, EurocAndKalibrKeepTheReadoutTimes) {
  const testing::TemporaryFolder folder;
  StereoCalibration rig = some_rig();
  rig.readout_time_s = {0.024, -0.012};
  static_cast<void>(write_rig_files(folder.path(), rig, std::nullopt));
  EXPECT_EQ(read_rig_file(folder.path()).calibration.readout_time_s, rig.readout_time_s);
  const auto kalibr = read_rig_file(folder.path() / "camchain.yaml").calibration.readout_time_s;
  EXPECT_NEAR(kalibr[0], 0.024, 1e-12);
  EXPECT_NEAR(kalibr[1], -0.012, 1e-12);
  EXPECT_EQ(euroc_sensor_yaml(some_rig(), 0).find("readout"), std::string::npos) << "all rows at once";
}

TEST(WriteRigFiles, TheRectifiedPairSeesOnePointInOneRowAndItsDepthInTheDisparity) {
  const testing::TemporaryFolder folder;
  const StereoCalibration rig = some_rig();
  static_cast<void>(write_rig_files(folder.path(), rig, std::nullopt));
  const RigFile raw = read_rig_file(folder.path() / "stereo.yml", ImageKind::kRaw);
  const RigFile rectified = read_rig_file(folder.path() / "stereo.yml", ImageKind::kRectified);
  const RigFile kitti = read_rig_file(folder.path() / "calib.txt");
  EXPECT_EQ(kitti.images, ImageKind::kRectified);
  EXPECT_EQ(kitti.calibration.theta, rectified.calibration.theta);
  EXPECT_EQ(kitti.calibration.cam0.fu, rectified.calibration.cam0.fu);
  EXPECT_EQ(kitti.calibration.cam0.width, 0) << "calib.txt does not say";
  EXPECT_NEAR(rectified.calibration.theta(3), -raw.calibration.baseline(), 1e-15);
}

TEST(WriteRigFiles, RefusesWhatNoFileCanSay) {
  StereoCalibration rig = some_rig();
  rig.body = BodyFrame::kMiddleOfBaseline;
  EXPECT_NE(testing::message_of([&] { static_cast<void>(kalibr_camchain(rig)); }).find("kMiddleOfBaseline"),
            std::string::npos);
  rig = some_rig();
  rig.cam0.fu = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(testing::message_of([&] { static_cast<void>(euroc_sensor_yaml(rig, 0)); }).find("finite"),
            std::string::npos);
  EXPECT_NE(testing::message_of([&] {
              static_cast<void>(kitti_cam_to_cam(some_rig(Equidistant{})));
            }).find("equidistant"),
            std::string::npos);
}

}  // namespace
}  // namespace limber
