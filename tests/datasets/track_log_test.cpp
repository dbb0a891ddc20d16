// SPDX-License-Identifier: MIT
#include "limber/datasets/track_log.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "files.hpp"
#include "limber/datasets/read_recording.hpp"
#include "small_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::read_text;
using testing::replaced;
using testing::small_recording;
using testing::TemporaryFolder;
using testing::write_text;

// What quaternions and products of poses cost.
constexpr double kRounding = 2e-15;

// A log on disk, to be changed by the test.
class TrackLog : public ::testing::Test {
 protected:
  TrackLog() { write_track_log(small_recording(), folder_.path()); }

  void edit(const std::string& file, const std::string& from, const std::string& to) const {
    write_text(mav0() / file, replaced(read_text(mav0() / file), from, to));
  }
  [[nodiscard]] fs::path mav0() const { return folder_.path() / "mav0"; }
  [[nodiscard]] Recording read() const { return read_recording(folder_.path()); }

 private:
  TemporaryFolder folder_;
};

TEST_F(TrackLog, GivesBackEveryCalibrationNumber) {
  const StereoCalibration expected = small_recording().calibration;
  const StereoCalibration actual = read().calibration;
  EXPECT_EQ(actual.body, BodyFrame::kImu);
  EXPECT_EQ(actual.cam0.fu, expected.cam0.fu);
  EXPECT_EQ(actual.cam1.fv, expected.cam1.fv);
  EXPECT_EQ(actual.cam0.cu, expected.cam0.cu);
  EXPECT_EQ(actual.cam1.cv, expected.cam1.cv);
  EXPECT_EQ(actual.cam1.width, 752);
  EXPECT_EQ(actual.cam1.height, 480);
  const auto k0 = std::get<RadialTangential>(actual.cam0.distortion);
  EXPECT_EQ(k0.k1, -0.28);
  EXPECT_EQ(k0.k2, 0.07);
  EXPECT_EQ(k0.p1, 1.9e-4);
  EXPECT_EQ(k0.p2, 1.7e-05);
  const auto k1 = std::get<Equidistant>(actual.cam1.distortion);
  EXPECT_EQ(k1.k1, 0.01);
  EXPECT_EQ(k1.k2, -0.02);
  EXPECT_EQ(k1.k3, 1.0 / 3.0);
  EXPECT_EQ(k1.k4, 4e-9);
  EXPECT_EQ(actual.T_body_cam0.p, expected.T_body_cam0.p);
  EXPECT_LE((actual.T_body_cam0.R - expected.T_body_cam0.R).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_LE((actual.theta - expected.theta).cwiseAbs().maxCoeff(), kRounding);
}

TEST_F(TrackLog, GivesBackEverySample) {
  const Recording expected = small_recording();
  const Recording actual = read();
  ASSERT_EQ(actual.imu.size(), expected.imu.size());
  ASSERT_EQ(actual.odometry.size(), expected.odometry.size());
  for (std::size_t k = 0; k < expected.imu.size(); ++k) {
    EXPECT_EQ(actual.imu[k].t_ns, expected.imu[k].t_ns);
    EXPECT_EQ(actual.imu[k].omega_imu, expected.imu[k].omega_imu);
    EXPECT_EQ(actual.imu[k].accel_imu, expected.imu[k].accel_imu);
    EXPECT_EQ(actual.odometry[k].t_ns, expected.odometry[k].t_ns);
    EXPECT_EQ(actual.odometry[k].v_body, expected.odometry[k].v_body);
    EXPECT_EQ(actual.odometry[k].omega_body, expected.odometry[k].omega_body);
  }
  EXPECT_EQ(actual.imu_noise->gyro_density, expected.imu_noise->gyro_density);
  EXPECT_EQ(actual.imu_noise->gyro_walk, expected.imu_noise->gyro_walk);
  EXPECT_EQ(actual.imu_noise->accel_density, expected.imu_noise->accel_density);
  EXPECT_EQ(actual.imu_noise->accel_walk, expected.imu_noise->accel_walk);
  EXPECT_EQ(actual.odometry_noise->sigma_v, expected.odometry_noise->sigma_v);
  EXPECT_EQ(actual.odometry_noise->sigma_omega, expected.odometry_noise->sigma_omega);
  EXPECT_EQ(*actual.pixel_noise, *expected.pixel_noise);
  EXPECT_TRUE(actual.notes.empty()) << actual.notes.front();
}

TEST_F(TrackLog, GivesBackEveryPixel) {
  const Recording expected = small_recording();
  const Recording actual = read();
  ASSERT_EQ(actual.frames.size(), expected.frames.size());
  for (std::size_t k = 0; k < expected.frames.size(); ++k) {
    EXPECT_EQ(actual.frames[k].t_ns, expected.frames[k].t_ns);
    ASSERT_EQ(actual.frames[k].observations.size(), expected.frames[k].observations.size());
    for (std::size_t i = 0; i < expected.frames[k].observations.size(); ++i) {
      const StereoObservation& a = actual.frames[k].observations[i];
      const StereoObservation& e = expected.frames[k].observations[i];
      EXPECT_EQ(a.track_id, e.track_id);
      EXPECT_EQ(a.in_cam0, e.in_cam0);
      EXPECT_EQ(a.in_cam1, e.in_cam1);
      EXPECT_EQ(a.uv_cam0, e.uv_cam0);
      EXPECT_EQ(a.uv_cam1, e.uv_cam1);
    }
  }
}

TEST_F(TrackLog, GivesBackTheTruth) {
  const Recording expected = small_recording();
  const Recording actual = read();
  ASSERT_EQ(actual.truth.motion.states.size(), expected.truth.motion.states.size());
  EXPECT_TRUE(actual.truth.motion.has_velocity);
  EXPECT_TRUE(actual.truth.motion.has_biases);
  for (std::size_t k = 0; k < expected.truth.motion.states.size(); ++k) {
    const GroundTruthState& a = actual.truth.motion.states[k];
    const GroundTruthState& e = expected.truth.motion.states[k];
    EXPECT_EQ(a.t_ns, e.t_ns);
    EXPECT_EQ(a.p_world_body, e.p_world_body);
    EXPECT_EQ(a.v_world_body, e.v_world_body);
    EXPECT_EQ(a.bias_gyro, e.bias_gyro);
    EXPECT_EQ(a.bias_accel, e.bias_accel);
    EXPECT_LE((a.R_world_body - e.R_world_body).cwiseAbs().maxCoeff(), kRounding);
  }
  EXPECT_EQ(actual.truth.landmarks, expected.truth.landmarks);
  ASSERT_EQ(actual.truth.rig.size(), expected.truth.rig.size());
  for (std::size_t k = 0; k < expected.truth.rig.size(); ++k) {
    EXPECT_EQ(actual.truth.rig[k].t_ns, expected.truth.rig[k].t_ns);
    EXPECT_EQ(actual.truth.rig[k].theta, expected.truth.rig[k].theta);
  }
}

TEST_F(TrackLog, IsTheSameTextWhenReadAndWrittenAgain) {
  const TemporaryFolder second;
  const TemporaryFolder third;
  write_track_log(read(), second.path());
  write_track_log(read_recording(second.path()), third.path());
  for (const char* const file :
       {"tracks0/data.csv", "imu0/data.csv", "imu0/sensor.yaml", "odometry0/data.csv"}) {
    EXPECT_EQ(read_text(second.path() / "mav0" / file), read_text(mav0() / file)) << file;
    EXPECT_EQ(read_text(third.path() / "mav0" / file), read_text(mav0() / file)) << file;
  }
}

TEST_F(TrackLog, IsFoundFromMav0ItselfAndNamedAfterItsFolder) {
  const Recording from_parent = read();
  const Recording from_mav0 = read_recording(mav0());
  EXPECT_EQ(from_mav0.frames.size(), from_parent.frames.size());
  EXPECT_EQ(from_mav0.name, mav0().parent_path().filename().string());
  EXPECT_EQ(read_recording(mav0().parent_path() / "").name, from_mav0.name);
}

TEST_F(TrackLog, MayHaveWindowsLineEndsCommentsBlankLinesAndSpaces) {
  std::string text = read_text(mav0() / "tracks0/data.csv");
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 2)) {
    text.replace(at, 1, "\r\n");
  }
  text = replaced(text, ",7,", " , 7 ,");
  write_text(mav0() / "tracks0/data.csv",
             "\xef\xbb\xbf# made by hand\r\n" + text + "\r\n  \r\n# the end\r\n\n");
  const Recording actual = read();
  ASSERT_EQ(actual.frames.size(), 3U);
  EXPECT_EQ(actual.frames[0].observations[0].uv_cam1.y(), 0.33);
  EXPECT_EQ(actual.frames[2].observations[0].uv_cam1.y(), 0.1 + 0.2);
}

TEST_F(TrackLog, SaysWhatItDoesNotGive) {
  fs::remove(mav0() / "tracks0/sensor.yaml");
  fs::remove(mav0() / "odometry0/sensor.yaml");
  edit("imu0/sensor.yaml", "gyroscope_random_walk:", "some_other_key:");
  const Recording actual = read();
  EXPECT_FALSE(actual.pixel_noise.has_value());
  EXPECT_FALSE(actual.odometry_noise.has_value());
  EXPECT_FALSE(actual.imu_noise.has_value());
  ASSERT_EQ(actual.notes.size(), 3U);
  EXPECT_NE(actual.notes[0].find("gyroscope_random_walk"), std::string::npos);
  EXPECT_NE(actual.notes[1].find("sigma_v"), std::string::npos);
  EXPECT_NE(actual.notes[2].find("sigma_px"), std::string::npos);
}

TEST_F(TrackLog, NotesPixelsThatLieOutsideOfTheStatedImages) {
  edit("cam1/sensor.yaml", "resolution: [752, 480]", "resolution: [64, 480]");
  const Recording actual = read();
  ASSERT_EQ(actual.notes.size(), 1U);
  EXPECT_NE(actual.notes[0].find("pixels of cam1 lie outside of its 64 x 480 images, the first in line"),
            std::string::npos)
      << actual.notes[0];
}

TEST_F(TrackLog, NotesALastLineWithoutEnd) {
  std::string text = read_text(mav0() / "imu0/data.csv");
  text.pop_back();
  write_text(mav0() / "imu0/data.csv", text);
  const Recording actual = read();
  EXPECT_EQ(actual.imu.size(), 4U);
  ASSERT_EQ(actual.notes.size(), 1U);
  EXPECT_NE(actual.notes[0].find("imu0/data.csv"), std::string::npos);
}

TEST_F(TrackLog, NeedsNeitherImuNorOdometryNorTruth) {
  for (const char* const folder :
       {"imu0", "odometry0", "state_groundtruth_estimate0", "landmarks0", "calibration_truth0"}) {
    fs::remove_all(mav0() / folder);
  }
  const Recording actual = read();
  EXPECT_EQ(actual.frames.size(), 3U);
  EXPECT_TRUE(actual.imu.empty() && actual.odometry.empty() && actual.truth.motion.states.empty());
  EXPECT_TRUE(actual.truth.landmarks.empty() && actual.truth.rig.empty());
  EXPECT_EQ(actual.calibration.body, BodyFrame::kImu);
}

TEST_F(TrackLog, TakesOpenCvsYamlDirectiveAndRadtan) {
  edit("cam0/sensor.yaml", "sensor_type", "%YAML:1.0\n# comment\nsensor_type");
  edit("cam0/sensor.yaml", "radial-tangential", "radtan");
  EXPECT_TRUE(std::holds_alternative<RadialTangential>(read().calibration.cam0.distortion));
}

TEST_F(TrackLog, MakesASlightlyRoundedRotationExact) {
  const std::string text = read_text(mav0() / "cam0/sensor.yaml");
  const std::size_t begin = text.find("data: [");
  const std::size_t end = text.find(']', begin);
  write_text(
      mav0() / "cam0/sensor.yaml",
      replaced(
          text, text.substr(begin, end - begin),
          "data: [0.0149, -0.9999, 0.0041, -0.02, 0.9996, 0.0150, 0.0257, -0.06, -0.0258, 0.0038, 0.9997, "
          "0.01, 0, 0, 0, 1"));
  const Eigen::Matrix3d R = read().calibration.T_body_cam0.R;
  EXPECT_LE((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_NEAR(R(0, 1), -0.9999, 1e-4);
}

TEST(TrackLogWriter, StoresACameraBodyThatComesBackAsSuch) {
  const TemporaryFolder folder;
  Recording recording = small_recording();
  recording.imu.clear();
  recording.odometry.clear();
  recording.calibration.body = BodyFrame::kCam0;
  recording.calibration.T_body_cam0 = {};
  recording.calibration.theta << 0, 0, 0, -2, 0, 0;
  recording.calibration.cam0.distortion = NoDistortion{};
  write_track_log(recording, folder.path());
  const StereoCalibration actual = read_recording(folder.path()).calibration;
  EXPECT_EQ(actual.body, BodyFrame::kCam0);
  EXPECT_EQ(actual.theta, recording.calibration.theta);
  EXPECT_EQ(actual.T_body_cam0.R, Eigen::Matrix3d::Identity());
  EXPECT_TRUE(std::holds_alternative<NoDistortion>(actual.cam0.distortion));
}

TEST(TrackLogWriter, LeavesOutTheColumnsThatTheGroundTruthDoesNotHave) {
  const TemporaryFolder folder;
  Recording recording = small_recording();
  recording.truth.motion.has_biases = false;
  write_track_log(recording, folder.path());
  Recording actual = read_recording(folder.path());
  EXPECT_TRUE(actual.truth.motion.has_velocity);
  EXPECT_FALSE(actual.truth.motion.has_biases);
  EXPECT_EQ(actual.truth.motion.states[0].bias_gyro, Eigen::Vector3d::Zero());
  recording.truth.motion.has_velocity = false;
  write_track_log(recording, folder.path(), true);
  actual = read_recording(folder.path());
  EXPECT_FALSE(actual.truth.motion.has_velocity);
  EXPECT_EQ(actual.truth.motion.states.size(), recording.truth.motion.states.size());
}

TEST(TrackLogWriter, ReplacesAnOlderLogAsAWholeWhereItMay) {
  const TemporaryFolder folder;
  write_track_log(small_recording(), folder.path());
  Recording without_imu = small_recording();
  without_imu.imu.clear();
  EXPECT_THROW(write_track_log(without_imu, folder.path()), DataError);
  EXPECT_TRUE(fs::exists(folder.path() / "mav0/imu0"));
  write_track_log(without_imu, folder.path(), true);
  EXPECT_FALSE(fs::exists(folder.path() / "mav0/imu0"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1) << "something temporary was left";
}

TEST(TrackLogWriter, DoesNotReplaceWhatItDidNotWrite) {
  const TemporaryFolder folder;
  write_track_log(small_recording(), folder.path());
  const fs::path image = write_text(folder.path() / "mav0/cam0/data/1.png", "precious");
  const DataError error =
      testing::data_error_of([&] { write_track_log(small_recording(), folder.path(), true); });
  EXPECT_NE(std::string(error.what()).find("cam0/data"), std::string::npos) << error.what();
  EXPECT_EQ(read_text(image), "precious");
}

TEST(TrackLogWriter, NamesAPlaceThatCannotBeWritten) {
  const TemporaryFolder folder;
  const fs::path file = write_text(folder.path() / "file", "not a folder");
  const DataError error = testing::data_error_of([&] { write_track_log(small_recording(), file / "log"); });
  EXPECT_NE(error.file().find("file"), std::string::npos);
  EXPECT_EQ(read_text(file), "not a folder");
}

TEST(TrackLogWriter, LeavesNothingBehindWhenItRefuses) {
  const auto expect_refused = [](const std::function<void(Recording&)>& spoil) {
    const TemporaryFolder folder;
    Recording recording = small_recording();
    spoil(recording);
    EXPECT_THROW(write_track_log(recording, folder.path()), std::invalid_argument);
    EXPECT_TRUE(fs::is_empty(folder.path()));
  };
  expect_refused([](Recording& r) { r.frames.clear(); });
  expect_refused([](Recording& r) { r.frames[2].t_ns = r.frames[1].t_ns; });
  expect_refused([](Recording& r) { std::swap(r.imu[0], r.imu[1]); });
  expect_refused([](Recording& r) { r.imu[1].omega_imu.x() = std::numeric_limits<double>::quiet_NaN(); });
  expect_refused([](Recording& r) { r.calibration.theta[3] = std::numeric_limits<double>::infinity(); });
  expect_refused([](Recording& r) { r.frames[0].observations[0].uv_cam0.x() = std::nan(""); });
  expect_refused([](Recording& r) {
    r.frames[0].observations[0].in_cam0 = r.frames[0].observations[0].in_cam1 = false;
  });
  expect_refused([](Recording& r) { r.frames[0].observations[1].track_id = 7; });
  expect_refused([](Recording& r) { r.pixel_noise->x() = 0.0; });
  expect_refused([](Recording& r) { r.imu_noise->gyro_walk = -1.0; });
  expect_refused([](Recording& r) { r.calibration.body = BodyFrame::kMiddleOfBaseline; });
}

}  // namespace
}  // namespace limber
