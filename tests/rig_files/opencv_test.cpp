// SPDX-License-Identifier: MIT
// Files of the real writers and readers: OpenCV's cv::FileStorage, yaml-cpp.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "datasets/files.hpp"
#include "limber/rig_files/rig_file.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "rig_files/rigs.hpp"

namespace limber {
namespace {

using testing::some_rig;

cv::Mat matrix(const cv::FileStorage& file, const char* name) {
  cv::Mat out;
  file[name] >> out;
  EXPECT_FALSE(out.empty()) << name;
  return out;
}

/// Pixel of X (of cam0) in the image of a camera at (R, t), by OpenCV.
cv::Point2d project_by_opencv(const cv::Mat& R, const cv::Mat& t, const cv::Mat& K, const cv::Mat& D) {
  cv::Mat rotation;
  cv::Rodrigues(R, rotation);
  std::vector<cv::Point2d> out;
  cv::projectPoints(std::vector<cv::Point3d>{{0.4, -0.3, 3.0}}, rotation, t, K, D, out);
  return out.front();
}

TEST(OpenCvReads, TheWrittenRigAndSeesThePointWhereLimberDoes) {
  const testing::TemporaryFolder folder;
  const StereoCalibration rig = some_rig();
  static_cast<void>(write_rig_files(folder.path(), rig, std::nullopt));
  const cv::FileStorage file((folder.path() / "stereo.yml").string(), cv::FileStorage::READ);
  ASSERT_TRUE(file.isOpened());
  const Eigen::Vector3d X(0.4, -0.3, 3.0);
  const auto uv1 = project(rig.cam1, pose_from_rig(rig.theta) * X);
  ASSERT_TRUE(uv1);
  const cv::Point2d seen =
      project_by_opencv(matrix(file, "R"), matrix(file, "T"), matrix(file, "M2"), matrix(file, "D2"));
  EXPECT_NEAR(seen.x, uv1->uv.x(), 1e-9);
  EXPECT_NEAR(seen.y, uv1->uv.y(), 1e-9);
  std::vector<int> size;
  file["size"] >> size;
  EXPECT_EQ(size, (std::vector<int>{752, 480}));
}

TEST(OpenCvReads, RowsOfTheRectifiedPairThatCorrespond) {
  const testing::TemporaryFolder folder;
  const StereoCalibration rig = some_rig();
  static_cast<void>(write_rig_files(folder.path(), rig, std::nullopt));
  const cv::FileStorage file((folder.path() / "stereo.yml").string(), cv::FileStorage::READ);
  const Eigen::Vector3d X(0.4, -0.3, 3.0);
  const auto uv0 = project(rig.cam0, X), uv1 = project(rig.cam1, pose_from_rig(rig.theta) * X);
  std::vector<cv::Point2d> left, right;
  cv::undistortPoints(std::vector<cv::Point2d>{{uv0->uv.x(), uv0->uv.y()}}, left, matrix(file, "M1"),
                      matrix(file, "D1"), matrix(file, "R1"), matrix(file, "P1"));
  cv::undistortPoints(std::vector<cv::Point2d>{{uv1->uv.x(), uv1->uv.y()}}, right, matrix(file, "M2"),
                      matrix(file, "D2"), matrix(file, "R2"), matrix(file, "P2"));
  EXPECT_NEAR(left[0].y, right[0].y, 1e-4);
  const cv::Mat Q = matrix(file, "Q");
  std::vector<cv::Vec3d> back;
  cv::perspectiveTransform(std::vector<cv::Vec3d>{{left[0].x, left[0].y, left[0].x - right[0].x}}, back, Q);
  const cv::Mat R1 = matrix(file, "R1");
  const cv::Mat in_cam0 = R1.t() * cv::Mat(cv::Vec3d(back[0]));
  EXPECT_NEAR(in_cam0.at<double>(0), X.x(), 1e-4);
  EXPECT_NEAR(in_cam0.at<double>(2), X.z(), 1e-4);
}

TEST(OpenCvReads, TheWrittenCamchainAndSensorYaml) {
  const testing::TemporaryFolder folder;
  const StereoCalibration rig = some_rig();
  static_cast<void>(write_rig_files(folder.path(), rig, std::nullopt));
  const YAML::Node chain = YAML::LoadFile((folder.path() / "camchain.yaml").string());
  EXPECT_EQ(chain["cam1"]["intrinsics"][2].as<double>(), rig.cam1.cu);
  EXPECT_NEAR(chain["cam1"]["T_cn_cnm1"][0][3].as<double>(), rig.theta(3), 1e-15);
  EXPECT_EQ(chain["cam0"]["distortion_model"].as<std::string>(), "radtan");
  const YAML::Node sensor = YAML::LoadFile((folder.path() / "cam0/sensor.yaml").string());
  EXPECT_EQ(sensor["T_BS"]["data"].size(), 16U);
  EXPECT_EQ(sensor["T_BS"]["data"][3].as<double>(), rig.T_body_cam0.p.x());
}

TEST(OpenCvWrites, WhatIsReadHere) {
  const testing::TemporaryFolder folder;
  const std::string path = (folder.path() / "by_opencv.yml").string();
  {
    cv::FileStorage file(path, cv::FileStorage::WRITE);
    file << "size" << cv::Size(752, 480) << "M1"
         << (cv::Mat_<double>(3, 3) << 458, 0, 367, 0, 457, 248, 0, 0, 1) << "D1"
         << (cv::Mat_<double>(1, 5) << -0.28, 0.07, 2e-4, 2e-5, 0.0) << "M2"
         << (cv::Mat_<double>(3, 3) << 457, 0, 380, 0, 456, 255, 0, 0, 1) << "D2"
         << (cv::Mat_<double>(1, 5) << -0.28, 0.07, -1e-4, 3e-5, 0.0) << "R" << cv::Mat::eye(3, 3, CV_64F)
         << "T" << (cv::Mat_<double>(3, 1) << -0.11, 0.0, 0.0);
  }
  const RigFile rig = read_rig_file(path);
  EXPECT_EQ(rig.images, ImageKind::kRaw);
  EXPECT_EQ(rig.calibration.cam0.width, 752);
  EXPECT_EQ(rig.calibration.cam1.fv, 456.0);
  EXPECT_EQ(std::get<RadialTangential>(rig.calibration.cam1.distortion).p1, -1e-4);
  EXPECT_EQ(rig.calibration.theta(3), -0.11);
  EXPECT_EQ(rig.calibration.body, BodyFrame::kCam0);
}

}  // namespace
}  // namespace limber
