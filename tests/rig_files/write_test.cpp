// SPDX-License-Identifier: MIT
#include "limber/rig_files/write_rig_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "datasets/files.hpp"
#include "limber/rig_files/rig_file.hpp"
#include "message_of.hpp"
#include "rig_files/rigs.hpp"

namespace limber {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using testing::expect_same_camera;
using testing::expect_same_pose;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::some_rig;

class WrittenRig : public ::testing::TestWithParam<Distortion> {};

TEST_P(WrittenRig, ComesBackFromEveryFormatThatSaysItAll) {
  const testing::TemporaryFolder folder;
  StereoCalibration rig = some_rig(GetParam());
  const auto names = write_rig_files(folder.path(), rig, ImuNoise{});
  for (const char* name : {"", "camchain.yaml", "stereo.yml", "calib_cam_to_cam.txt"}) {
    SCOPED_TRACE(name);
    if (!std::filesystem::exists(folder.path() / name)) {
      EXPECT_THAT(rig_files_left_out(rig), Contains(name + std::string(" is not written: it cannot say ") +
                                                    std::string(model_name(GetParam())) + " distortion"));
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

INSTANTIATE_TEST_SUITE_P(
    Distortions, WrittenRig,
    ::testing::Values(Distortion{NoDistortion{}}, Distortion{RadialTangential{-0.28, 0.07, 2e-4, 2e-5}},
                      Distortion{Equidistant{-0.006, 0.03, -0.034, 0.0148}},
                      Distortion{Rational{-0.37, 0.2, 2e-3, 1e-3, -0.07, 0.0, 0.0, 0.0}},
                      Distortion{Rational{0.46, -2.6, 1e-3, -2e-4, 1.5, 0.34, -2.4, 1.4}},
                      Distortion{Omni{0.8, 0.0, 0.0, 0.0, 0.0}},
                      Distortion{Omni{1.9, -0.33, 0.13, 6e-4, 5e-4}}));

TEST(WriteRigFiles, EachFormatIsLeftOutForTheLensesItHasNoWordFor) {
  const auto left_out = [](const Distortion& distortion) { return rig_files_left_out(some_rig(distortion)); };
  EXPECT_THAT(left_out(RadialTangential{-0.28, 0.07, 2e-4, 2e-5}), IsEmpty());
  EXPECT_THAT(left_out(Equidistant{}), ElementsAre(HasSubstr("calib_cam_to_cam.txt")));
  EXPECT_THAT(left_out(Rational{.k3 = 0.1}), ElementsAre(HasSubstr("camchain.yaml")));
  EXPECT_THAT(left_out(Rational{.k4 = 0.1}),
              ElementsAre(HasSubstr("camchain.yaml"), HasSubstr("calib_cam_to_cam.txt")));
  EXPECT_THAT(left_out(Omni{.xi = 1.0}),
              ElementsAre(HasSubstr("stereo.yml"), HasSubstr("calib_cam_to_cam.txt")));
  StereoCalibration uneven = some_rig(RadialTangential{-0.28, 0.07, 2e-4, 2e-5});
  uneven.cam1.width *= 2;
  EXPECT_THAT(rig_files_left_out(uneven),
              ElementsAre(std::string("stereo.yml is not written: it cannot say images of two sizes")));
  StereoCalibration mixed = some_rig(Rational{.k4 = 0.1});
  mixed.cam1.distortion = RadialTangential{-0.28, 0.07, 2e-4, 2e-5};
  EXPECT_NO_THROW(static_cast<void>(opencv_stereo_yaml(mixed))) << "eight coefficients and four";
  mixed.cam1.distortion = Equidistant{};
  EXPECT_NE(testing::message_of([&] {
              static_cast<void>(opencv_stereo_yaml(mixed));
            }).find("stereo.yml cannot say rational-polynomial and equidistant distortion"),
            std::string::npos);
}

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
