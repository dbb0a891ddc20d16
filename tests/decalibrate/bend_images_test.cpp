// SPDX-License-Identifier: MIT
#include "limber/decalibrate/bend_images.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "datasets/files.hpp"
#include "decalibrate/rotation_warp.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/recording_place.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

const Camera kCamera{230.0, 229.0, 160.0, 118.0, 320, 240, RadialTangential{-0.28, 0.07, 2e-4, 1e-4}};
const Camera kFisheye{150.0, 151.0, 161.0, 119.0, 320, 240, Equidistant{0.01, -0.005, 0.001, 0.0}};
constexpr double kBlob = 2.5;  ///< [px], standard deviation

/// Bright blobs on grey.
cv::Mat blobs(const std::vector<Eigen::Vector2d>& places) {
  cv::Mat image(kCamera.height, kCamera.width, CV_16U);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      double grey = 1000.0;
      for (const Eigen::Vector2d& at : places) {
        grey += 50'000.0 * std::exp(-0.5 * (Eigen::Vector2d(u, v) - at).squaredNorm() / (kBlob * kBlob));
      }
      image.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(grey);
    }
  }
  return image;
}

/// Centre of the light near `around`.
Eigen::Vector2d centre_near(const cv::Mat& image, const Eigen::Vector2d& around) {
  double sum = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (int dv = -10; dv <= 10; ++dv) {
    for (int du = -10; du <= 10; ++du) {
      const int u = static_cast<int>(std::lround(around.x())) + du,
                v = static_cast<int>(std::lround(around.y())) + dv;
      const double light = image.at<std::uint16_t>(v, u) - 1000.0;
      sum += light;
      moment += light * Eigen::Vector2d(u, v);
    }
  }
  return moment / sum;
}

class RotationWarpOf : public ::testing::TestWithParam<Camera> {};

TEST_P(RotationWarpOf, PutsPointsWhereTheTurnedCameraSeesThem) {
  const std::vector<Eigen::Vector2d> places = {
      {80, 70}, {160, 120}, {240.4, 80.7}, {90.3, 170.2}, {230, 165.5}};
  const Eigen::Matrix3d turn = so3_exp(Eigen::Vector3d(0.05, -0.06, 0.08));
  decalibrate::RotationWarp warp(GetParam());
  const cv::Mat turned = warp(blobs(places), turn);
  for (const Eigen::Vector2d& place : places) {
    const auto expected = project(GetParam(), turn * *unproject(GetParam(), place));
    ASSERT_TRUE(expected && in_image(GetParam(), expected->uv, 12.0));
    // A blob is bent as well as moved: its centre of light is that of its point to first order alone.
    EXPECT_LT((centre_near(turned, expected->uv) - expected->uv).norm(), 0.03) << place.transpose();
  }
}
INSTANTIATE_TEST_SUITE_P(Lenses, RotationWarpOf, ::testing::Values(kCamera, kFisheye));

TEST(RotationWarp, ComesBackByTheInverse) {
  cv::Mat image(kCamera.height, kCamera.width, CV_8UC3);
  cv::theRNG().state = 7;
  cv::randu(image, 0, 255);
  cv::GaussianBlur(image, image, {}, 2.0);
  const Eigen::Matrix3d turn = so3_exp(Eigen::Vector3d(0.01, -0.02, 0.03));
  decalibrate::RotationWarp warp(kCamera);
  const cv::Mat again = warp(warp(image, turn), turn.transpose());
  EXPECT_GT(warp.black_share(), 0.005);
  EXPECT_LT(warp.black_share(), 0.1);
  const cv::Rect middle(40, 40, kCamera.width - 80, kCamera.height - 80);
  EXPECT_LT(cv::norm(again(middle), image(middle), cv::NORM_INF), 4.0);
  EXPECT_GT(cv::norm(warp(image, turn)(middle), image(middle), cv::NORM_INF), 20.0);
}

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write_euroc(const fs::path& folder) {
  const std::string camera =
      "camera_model: pinhole\nresolution: [320, 240]\nintrinsics: [230, 229, 160, 118]\n"
      "distortion_model: radial-tangential\ndistortion_coefficients: [-0.28, 0.07, 0.0002, 0.0001]\n"
      "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, ";
  const std::string rest = ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";
  write(folder / "mav0/cam0/sensor.yaml", camera + "0" + rest);
  write(folder / "mav0/cam1/sensor.yaml", camera + "0.1" + rest);
  write(folder / "mav0/imu0/data.csv", "1000000000,0,0,0,0,0,9.81\n1050000000,0,0,0,0,0,9.81\n");
  for (const char* name : {"cam0", "cam1"}) {
    std::string list;
    for (int k = 0; k < 3; ++k) {
      const std::string image = std::to_string(k) + (k == 2 ? ".jpg" : ".png");
      list += std::to_string(1'000'000'000 + 50'000'000 * k) + "," + image + "\n";
      fs::create_directories(folder / "mav0" / name / "data");
      cv::Mat picture = blobs({{100.0 + k, 100.0}, {200.0, 150.0}});
      if (k == 2) picture.convertTo(picture, CV_8U, 1.0 / 256.0);
      cv::imwrite((folder / "mav0" / name / "data" / image).string(), picture);
    }
    write(folder / "mav0" / name / "data.csv", list);
  }
}

TEST(BendImages, LeavesEverythingButTheRightImagesAndTellsTheTruth) {
  const testing::TemporaryFolder scratch;
  const fs::path from = scratch.path() / "from", to = scratch.path() / "to";
  write_euroc(from);
  const Recording sound = read_recording(from);
  DecalibrationSignal signal;
  signal.amplitude << 0.0, 0.02, 0.01, 0.0, 0.0, 0.0;
  signal.shape = StepsShape{{{0.05, 1.0}}};
  const BentRig rig(sound, {signal}, 0, BentRig::Parts::kRotation);
  EXPECT_EQ(bend_images(sound, rig, to).images, 3u);

  const Recording bent = read_recording(to);
  ASSERT_EQ(bent.images.size(), 3u);
  EXPECT_EQ(bent.calibration.theta, sound.calibration.theta);
  EXPECT_EQ(bent.imu.size(), sound.imu.size());
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(bent.images[k].t_ns, sound.images[k].t_ns);
    EXPECT_EQ(bytes_of(bent.images[k].cam0), bytes_of(sound.images[k].cam0));
  }
  // Before the step nothing moves; 16 bits stay 16 bits; what was JPEG is PNG.
  const cv::Mat first = cv::imread(bent.images[0].cam1.string(), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(first.type(), CV_16U);
  EXPECT_EQ(cv::norm(first, cv::imread(sound.images[0].cam1.string(), cv::IMREAD_UNCHANGED), cv::NORM_INF),
            0.0);
  EXPECT_EQ(bent.images[2].cam1.extension(), ".png");
  // After it the right camera has turned about its centre, and the truth says so.
  const Pose T_cam1_cam0 = pose_from_rig(bent.truth.rig.back().theta);
  EXPECT_TRUE(T_cam1_cam0.inverse().p.isApprox(Eigen::Vector3d(0.1, 0.0, 0.0), 1e-12));
  EXPECT_NEAR(bent.truth.rig.back().theta[1], 0.02, 1e-12);
  const auto expected = project(kCamera, T_cam1_cam0.R * *unproject(kCamera, {101.0, 100.0}));
  const cv::Mat second = cv::imread(bent.images[1].cam1.string(), cv::IMREAD_UNCHANGED);
  EXPECT_LT((centre_near(second, expected->uv) - expected->uv).norm(), 0.03);
}

TEST(BendImages, OfKittiFoldersTellTheTruthToo) {
  const testing::TemporaryFolder scratch;
  const fs::path from = scratch.path() / "from", to = scratch.path() / "to";
  write(from / "calib.txt", "P0: 230 0 160 0 0 230 120 0 0 0 1 0\nP1: 230 0 160 -23 0 230 120 0 0 0 1 0\n");
  write(from / "times.txt", "0.0\n0.1\n");
  write(from / "README.md", "No part of the recording.\n");
  for (const char* folder : {"image_0", "image_1"}) {
    fs::create_directories(from / folder);
    for (const char* name : {"000000.png", "000001.png"})
      cv::imwrite((from / folder / name).string(), blobs({{100.0, 100.0}}));
  }
  const Recording sound = read_recording(from);
  DecalibrationSignal signal;
  signal.amplitude << 0.0, 0.0, 0.03, 0.0, 0.0, 0.0;
  EXPECT_EQ(bend_images(sound, BentRig(sound, {signal}, 0, BentRig::Parts::kRotation), to).images, 2u);
  const Recording bent = read_recording(to);
  ASSERT_EQ(bent.truth.rig.size(), 2u);
  EXPECT_NEAR(bent.truth.rig.front().theta[2], 0.03, 1e-12);
  EXPECT_EQ(bytes_of(bent.images[1].cam0), bytes_of(sound.images[1].cam0));
  EXPECT_NE(bytes_of(bent.images[1].cam1), bytes_of(sound.images[1].cam1));
  EXPECT_FALSE(fs::exists(to / "README.md"));
  EXPECT_NO_THROW(require_place_for_recording(to, true)) << "--force replaces what limber wrote";
}

}  // namespace
}  // namespace limber
