// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "datasets/files.hpp"
#include "limber/core/errors.hpp"
#include "limber/rig_files/rig_file.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "real_data.hpp"
#include "rig_files/rigs.hpp"

namespace limber {
namespace {

using ::testing::AllOf;
using testing::data_error_of;
using ::testing::HasSubstr;
using testing::replaced;
using testing::some_rig;
using testing::TemporaryFolder;
using testing::write_text;

double degrees_between(const StereoCalibration& a, const StereoCalibration& b) {
  return so3_log(pose_from_rig(a.theta).R.transpose() * pose_from_rig(b.theta).R).norm() * 180.0 / M_PI;
}

TEST(ReadRigFile, EveryRealKalibrChainWithTwoCameras) {
  LIMBER_NEED_DATA(folder, "calibrations/kalibr");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SCOPED_TRACE(entry.path().string());
    const auto chain = entry.path() / "kalibr_imucam_chain.yaml";
    EXPECT_GT(read_kalibr_imu(entry.path() / "kalibr_imu_chain.yaml").gyro_density, 0.0);
    if (entry.path().filename() == "rs_d455") {
      EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(chain)); }).what(),
                  HasSubstr("cam0 alone"));
      continue;
    }
    const RigFile rig = read_rig_file(chain);
    EXPECT_EQ(rig.calibration.body, BodyFrame::kImu);
    EXPECT_GT(rig.calibration.baseline(), 0.05);
    EXPECT_LT(rig.calibration.baseline(), 0.6);
    EXPECT_LT(rig.calibration.theta(3), 0.0);
  }
}

TEST(ReadRigFile, ThreeCalibrationsOfTheEurocRigAgree) {
  LIMBER_NEED_DATA(folder, "calibrations");
  const RigFile kalibr = read_rig_file(folder / "kalibr/euroc_mav/kalibr_imucam_chain.yaml");
  for (const char* other : {"cuvslam_euroc", "basalt/euroc_ds_calib.json"}) {
    SCOPED_TRACE(other);
    const RigFile rig = read_rig_file(folder / other);
    EXPECT_LT(degrees_between(rig.calibration, kalibr.calibration), 0.11) << "as their README says";
    EXPECT_NEAR(rig.calibration.baseline(), kalibr.calibration.baseline(),
                0.0025 * kalibr.calibration.baseline());
    // Where a point ahead lands, to a pixel or two: the models themselves agree.
    const auto a = project(rig.calibration.cam0, {0.5, 0.3, 1.0}),
               b = project(kalibr.calibration.cam0, {0.5, 0.3, 1.0});
    EXPECT_LT((a->uv - b->uv).norm(), 4.0);
    EXPECT_TRUE(rig.imu_noise);
    if (rig.calibration.body == BodyFrame::kImu) {
      EXPECT_LT((rig.calibration.T_body_cam0.p - kalibr.calibration.T_body_cam0.p).norm(), 0.02);
    }
  }
}

TEST(ReadRigFile, TumViByBasaltAndByKalibrSeeThePointsAtTheSamePixel) {
  LIMBER_NEED_DATA(folder, "calibrations");
  const RigFile basalt = read_rig_file(folder / "basalt/tumvi_512_ds_calib.json");
  const RigFile kalibr = read_rig_file(folder / "kalibr/tum_vi/kalibr_imucam_chain.yaml");
  for (const double x : {-1.5, -0.5, 0.0, 0.5, 1.5}) {
    const auto a = project(basalt.calibration.cam0, {x, 0.2, 1.0}),
               b = project(kalibr.calibration.cam0, {x, 0.2, 1.0});
    EXPECT_LT((a->uv - b->uv).norm(), 2.0) << x;
  }
  EXPECT_LT(degrees_between(basalt.calibration, kalibr.calibration), 0.3);
}

TEST(ReadRigFile, TakesTimeShiftAndChainOfTheCameras) {
  LIMBER_NEED_DATA(folder, "calibrations/kalibr/rs_t265");
  const RigFile rig = read_rig_file(folder / "kalibr_imucam_chain.yaml");
  EXPECT_EQ(rig.calibration.time_offset_s[0], 0.005618603727452336);
  EXPECT_NEAR(rig.calibration.theta(3), -0.06274034262839549, 1e-6);
  EXPECT_TRUE(std::holds_alternative<Equidistant>(rig.calibration.cam0.distortion));
}

TEST(ReadRigFile, TakesTheDelayOfALineInEitherUnit) {
  const TemporaryFolder folder;
  const auto readouts = [&](const std::string& line) {
    return read_rig_file(
               write_text(folder.path() / "camchain.yaml",
                          replaced(kalibr_camchain(some_rig()), "cam1:\n", "cam1:\n  " + line + "\n")))
        .calibration.readout_time_s;
  };
  const double height = some_rig().cam1.height;
  EXPECT_NEAR(readouts("line_delay: 3e-5")[1], 3e-5 * height, 1e-12);
  EXPECT_NEAR(readouts("line_delay_nanoseconds: 30000")[1], 3e-5 * height, 1e-12);
  EXPECT_EQ(readouts("line_delay: 3e-5")[0], 0.0);
  EXPECT_THAT(data_error_of([&] { static_cast<void>(readouts("line_delay: 30")); }).what(),
              HasSubstr("line_delay of at most 0.1 s"));
}

struct BadChain {
  const char *name, *from, *to, *words;
  int line;
};

class BadKalibr : public ::testing::TestWithParam<BadChain> {};

TEST_P(BadKalibr, IsRefusedWithItsLine) {
  const TemporaryFolder folder;
  const auto path = write_text(folder.path() / "camchain.yaml",
                               replaced(kalibr_camchain(some_rig()), GetParam().from, GetParam().to));
  const DataError error = data_error_of([&] { static_cast<void>(read_rig_file(path)); });
  EXPECT_EQ(error.file(), path.string());
  EXPECT_EQ(error.line(), static_cast<std::size_t>(GetParam().line)) << error.what();
  EXPECT_THAT(error.what(), HasSubstr(GetParam().words));
}

INSTANTIATE_TEST_SUITE_P(
    Kalibr, BadKalibr,
    ::testing::Values(BadChain{"Model", "camera_model: pinhole", "camera_model: fov",
                               "pinhole, omni, ds or eucm", 3},
                      BadChain{"Distortion", "radtan", "fov", "radtan, equidistant or none", 11},
                      BadChain{"Count", "intrinsics: [458.654, ", "intrinsics: [", "4 numbers", 10},
                      BadChain{"Focal", "intrinsics: [458.654", "intrinsics: [0", "focal lengths", 10},
                      BadChain{"Size", "resolution: [752", "resolution: [-752", "positive whole numbers", 13},
                      BadChain{"Chain", "T_cn_cnm1:\n  - [", "T_cn_cnm1:\n  - [3", "rotation", 25},
                      BadChain{"NoCamera", "cam1:", "cam2:", "cam0 alone", 0},
                      BadChain{"Word", "[458.654", "[four", "finite number", 10}),
    [](const auto& test) { return test.param.name; });

TEST(ReadRigFile, AnInvertedChainIsNamed) {
  const TemporaryFolder folder;
  StereoCalibration rig = some_rig();
  rig.theta = rig_from_pose(pose_from_rig(rig.theta).inverse());
  const auto path = write_text(folder.path() / "camchain.yaml", kalibr_camchain(rig));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(path)); }).what(),
              HasSubstr("T_cn_cnm1 inverted"));
}

/// A rig that looks along the IMU's x axis.
StereoCalibration rig_on_imu() {
  StereoCalibration rig = some_rig();
  rig.body = BodyFrame::kImu;
  rig.T_body_cam0.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  rig.T_body_cam0.p = {0.1, 0.05, -0.02};
  return rig;
}

/// Begin and length of T_cn_cnm1 in a camchain.
std::pair<std::size_t, std::size_t> place_of_chain(const std::string& text) {
  const std::size_t begin = text.find("  T_cn_cnm1:");
  return {begin, text.find("  intrinsics", begin) - begin};
}

/// The camchain of rig_on_imu with the T_cn_cnm1 of another one, or without.
std::string chain_with(const std::optional<Pose>& T_cam1_cam0) {
  std::string text = kalibr_camchain(rig_on_imu()), place;
  if (T_cam1_cam0) {
    StereoCalibration other = rig_on_imu();
    other.theta = rig_from_pose(*T_cam1_cam0);
    const std::string from = kalibr_camchain(other);
    const auto [begin, length] = place_of_chain(from);
    place = from.substr(begin, length);
  }
  const auto [begin, length] = place_of_chain(text);
  return text.replace(begin, length, place);
}

std::string named_the_other_way_round(const std::string& chain) {
  return replaced(replaced(chain, "T_cam_imu", "T_imu_cam"), "T_cam_imu", "T_imu_cam");
}

TEST(ReadRigFile, AChainThatContradictsItselfIsRefusedWhereOnePlaceIsInvertedAndNotedElse) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    return read_rig_file(write_text(folder.path() / "camchain.yaml", text));
  };
  const auto error_of = [&](const std::string& text) {
    return data_error_of([&] { static_cast<void>(read(text)); });
  };
  const Pose T_cam1_cam0 = pose_from_rig(rig_on_imu().theta);
  EXPECT_TRUE(read(chain_with(T_cam1_cam0)).notes.empty());
  const DataError error = error_of(named_the_other_way_round(chain_with(T_cam1_cam0)));
  EXPECT_THAT(error.what(), HasSubstr("T_imu_cam of both cameras that agrees with T_cn_cnm1 of cam1, found "
                                      "their inverses, which do: rename both to T_cam_imu"));
  EXPECT_GT(error.line(), 1U);
  EXPECT_THAT(error_of(chain_with(T_cam1_cam0.inverse())).what(),
              HasSubstr("T_cn_cnm1 (it maps cam0 to cam1 coordinates) that agrees with T_cam_imu, found its "
                        "inverse, which does"));
  const Pose longer{T_cam1_cam0.R, T_cam1_cam0.p - Eigen::Vector3d(0.05, 0, 0)};
  EXPECT_THAT(read(chain_with(longer)).notes,
              ::testing::ElementsAre(HasSubstr("contradict each other, by 50.0 mm and 0.00 deg")));
}

TEST(ReadRigFile, ABaselineThatTheOtherWayRoundLiesAlongXSaysSo) {
  const TemporaryFolder folder;
  const auto path =
      write_text(folder.path() / "camchain.yaml", named_the_other_way_round(chain_with(std::nullopt)));
  EXPECT_THAT(read_rig_file(path).notes,
              ::testing::ElementsAre(AllOf(HasSubstr("the baseline is mainly along the"),
                                           HasSubstr("(the other way round they say -0.1"))));
}

TEST(ReadRigFile, MillimetresOfAChessboardAreRefused) {
  const TemporaryFolder folder;
  const auto path = write_text(folder.path() / "stereo.yml",
                               replaced(opencv_stereo_yaml(some_rig()), "data: [-0.11,", "data: [-110,"));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(path, ImageKind::kRaw)); }).what(),
              HasSubstr("millimetres"));
}

TEST(ReadRigFile, RawOrRectifiedIsAsked) {
  const TemporaryFolder folder;
  for (const std::string& text : {opencv_stereo_yaml(some_rig()), kitti_cam_to_cam(some_rig())}) {
    const auto path = write_text(folder.path() / "both", text);
    EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(path)); }).what(),
                HasSubstr("raw or rectified"));
    EXPECT_EQ(read_rig_file(path, ImageKind::kRectified).images, ImageKind::kRectified);
  }
}

TEST(ReadRigFile, AThirdRadialCoefficientIsKept) {
  const TemporaryFolder folder;
  const auto path = write_text(folder.path() / "calib_cam_to_cam.txt",
                               replaced(kitti_cam_to_cam(some_rig()), " 0\nR_00", " -0.07\nR_00"));
  const RigFile rig = read_rig_file(path, ImageKind::kRaw);
  EXPECT_EQ(std::get<Rational>(rig.calibration.cam0.distortion).k3, -0.07);
  EXPECT_EQ(std::get<Rational>(rig.calibration.cam0.distortion).k4, 0.0);
  EXPECT_TRUE(std::holds_alternative<RadialTangential>(rig.calibration.cam1.distortion));
}

TEST(ReadRigFile, ASensorYamlMayHaveFiveOrEightCoefficients) {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& list) {
    for (const int camera : {0, 1}) {
      write_text(folder.path() / ("cam" + std::to_string(camera)) / "sensor.yaml",
                 replaced(euroc_sensor_yaml(some_rig(), camera), "[-0.28, 0.07, 0.0002, 2e-05]", list));
    }
    return read_rig_file(folder.path()).calibration.cam0.distortion;
  };
  EXPECT_EQ(coefficients(with("[-0.28, 0.07, 0.0002, 2e-05, -0.01]")),
            (std::vector<double>{-0.28, 0.07, 0.0002, 2e-05, -0.01, 0.0, 0.0, 0.0}));
  EXPECT_EQ(coefficients(with("[1, 2, 3, 4, 5, 6, 7, 8]")), (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_TRUE(std::holds_alternative<RadialTangential>(with("[-0.28, 0.07, 0.0002, 2e-05, 0]")));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(with("[1, 2, 3, 4, 5, 6]")); }).what(),
              HasSubstr("distortion_coefficients as a list of 4, 5 or 8 numbers, found 6 numbers"));
}

TEST(ReadRigFile, KalibrsOmniIsReadWithTheFocalLengthsOfTheAxis) {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& xi, const std::string& model) {
    std::string text = kalibr_camchain(some_rig());
    for (const char* const f : {"458.654", "457.587"}) {
      text = replaced(text, std::string("[") + f, "[" + xi + ", " + f);
    }
    for (int k = 0; k < 2; ++k) {
      text = replaced(replaced(text, "camera_model: pinhole", "camera_model: omni"), "model: radtan", model);
    }
    return read_rig_file(write_text(folder.path() / "camchain.yaml", text)).calibration.cam0;
  };
  const Camera camera = with("0.8", "model: radtan ");
  EXPECT_EQ(coefficients(camera.distortion), (std::vector<double>{0.8, -0.28, 0.07, 2e-4, 2e-5}));
  EXPECT_NEAR(camera.fu, 458.654 / 1.8, 1e-12);
  EXPECT_EQ(coefficients(with("0.8", "model: none").distortion),
            (std::vector<double>{0.8, 0.0, 0.0, 0.0, 0.0}));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(with("-1", "model: none")); }).what(),
              HasSubstr("xi above -1"));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(with("0.8", "model: equidistant")); }).what(),
              HasSubstr("radtan or none of an omni camera"));
}

TEST(ReadRigFile, APrismIsFoldedIntoTheModelOrRefused) {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& s1) {
    const std::string list = "-0.28, 0.07, 0.0002, 2e-05";
    return write_text(
        folder.path() / "stereo.yml",
        replaced(replaced(opencv_stereo_yaml(some_rig()), "cols: 4\n   dt: d\n   data: [" + list,
                          "cols: 12\n   dt: d\n   data: [" + list + ", 0, 0, 0, 0, " + s1 + ", 0, 0, 0"),
                 "plumb_bob", "rational_polynomial"));
  };
  const RigFile small = read_rig_file(with("1e-7"), ImageKind::kRaw);
  ASSERT_FALSE(small.notes.empty());
  EXPECT_THAT(small.notes.back(), HasSubstr("the same to"));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(with("0.5"), ImageKind::kRaw)); }).what(),
              AllOf(HasSubstr("camera 1"), HasSubstr("pinhole-radtan, pinhole-equi and omni-radtan")));
}

TEST(ReadRigFile, WhatIsNoCalibrationIsToldWhatWouldBeOne) {
  const TemporaryFolder folder;
  EXPECT_THAT(data_error_of([&] {
                static_cast<void>(read_rig_file(write_text(folder.path() / "a.yaml", "a: 1\n")));
              }).what(),
              HasSubstr("Kalibr camchain"));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(folder.path())); }).what(),
              HasSubstr("cam0/sensor.yaml"));
  const auto xml = write_text(folder.path() / "stereo.xml", "<?xml version=\"1.0\"?>\n<opencv_storage>\n");
  EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(xml)); }).what(),
              HasSubstr("ends in .yml"));
  const auto one = write_text(folder.path() / "sensor.yaml", euroc_sensor_yaml(some_rig(), 0));
  EXPECT_THAT(data_error_of([&] { static_cast<void>(read_rig_file(one)); }).what(), HasSubstr("the folder"));
}

TEST(ReadKalibrImu, SamplesThatNeedACorrectionFirstAreRefused) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "imu.yaml";
  write_text(path, kalibr_imu(ImuNoise{}) + "time_offset: 0.01\n");
  EXPECT_THAT(data_error_of([&] { static_cast<void>(read_kalibr_imu(path)); }).what(),
              HasSubstr("time_offset"));
  write_text(path, kalibr_imu(ImuNoise{}) + "Tw:\n  - [1.1, 0, 0]\n  - [0, 1, 0]\n  - [0, 0, 1]\n");
  const DataError error = data_error_of([&] { static_cast<void>(read_kalibr_imu(path)); });
  EXPECT_THAT(error.what(), HasSubstr("Tw that is the identity"));
  EXPECT_EQ(error.line(), 7u);
}

}  // namespace
}  // namespace limber
