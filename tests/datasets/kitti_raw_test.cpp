// SPDX-License-Identifier: MIT
// KITTI raw drives, made by hand with the numbers of 2011_09_26: PNG headers stand in for images.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>

#include "files.hpp"
#include "limber/core/random.hpp"
#include "limber/datasets/read_recording.hpp"

namespace limber {
namespace {

using namespace limber::testing;
using ::testing::Contains;
using ::testing::HasSubstr;

// Of KITTI's 2011_09_26, rounded; S_, D_ and R_ of the colour cameras are left out where nothing reads them.
const char* const kCameras =
    "calib_time: 09-Jan-2012 13:57:47\n"
    "corner_dist: 9.950000e-02\n"
    "S_00: 1.392000e+03 5.120000e+02\n"
    "K_00: 9.842439e+02 0 6.900000e+02 0 9.808141e+02 2.331966e+02 0 0 1\n"
    "D_00: -3.728755e-01 2.037299e-01 2.219027e-03 1.383707e-03 -7.233722e-02\n"
    "R_00: 1 0 0 0 1 0 0 0 1\n"
    "T_00: 2.573699e-16 -1.059758e-16 1.614870e-16\n"
    "S_rect_00: 1.242000e+03 3.750000e+02\n"
    "R_rect_00: 9.999239e-01 9.837760e-03 -7.445048e-03 -9.869795e-03 9.999421e-01 -4.278459e-03 "
    "7.402527e-03 "
    "4.351614e-03 9.999631e-01\n"
    "P_rect_00: 7.215377e+02 0 6.095593e+02 0 0 7.215377e+02 1.728540e+02 0 0 0 1 0\n"
    "S_01: 1.392000e+03 5.120000e+02\n"
    "K_01: 9.895267e+02 0 7.020000e+02 0 9.878386e+02 2.455590e+02 0 0 1\n"
    "D_01: -3.644661e-01 1.790019e-01 1.148107e-03 -6.298563e-04 -5.314062e-02\n"
    "R_01: 9.993513e-01 1.860866e-02 -3.083487e-02 -1.887662e-02 9.997863e-01 -8.421873e-03 3.067156e-02 "
    "8.998467e-03 9.994890e-01\n"
    "T_01: -5.370000e-01 4.822061e-03 -1.252488e-02\n"
    "S_rect_01: 1.242000e+03 3.750000e+02\n"
    "P_rect_01: 7.215377e+02 0 6.095593e+02 -3.875744e+02 0 7.215377e+02 1.728540e+02 0 0 0 1 0\n"
    "S_rect_02: 1.242000e+03 3.750000e+02\n"
    "P_rect_02: 7.215377e+02 0 6.095593e+02 4.485728e+01 0 7.215377e+02 1.728540e+02 2.163791e-01 0 0 1 "
    "2.745884e-03\n"
    "S_rect_03: 1.242000e+03 3.750000e+02\n"
    "P_rect_03: 7.215377e+02 0 6.095593e+02 -3.395242e+02 0 7.215377e+02 1.728540e+02 2.199936e+00 0 0 1 "
    "2.729905e-03\n";
const char* const kVelodyne =
    "calib_time: 15-Mar-2012 11:37:16\n"
    "R: 7.533745e-03 -9.999714e-01 -6.166020e-04 1.480249e-02 7.280733e-04 -9.998902e-01 9.998621e-01 "
    "7.523790e-03 1.480755e-02\n"
    "T: -4.069766e-03 -7.631618e-02 -2.717806e-01\n";
const char* const kImu =
    "calib_time: 25-May-2012 16:47:16\n"
    "R: 9.999976e-01 7.553071e-04 -2.035826e-03 -7.854027e-04 9.998898e-01 -1.482298e-02 2.024406e-03 "
    "1.482454e-02 9.998881e-01\n"
    "T: -8.086759e-01 3.195559e-01 -7.997231e-01\n";

class RawDrive : public ::testing::Test {
 protected:
  RawDrive() {
    write_text(day() / "calib_cam_to_cam.txt", kCameras);
    write_text(day() / "calib_velo_to_cam.txt", kVelodyne);
    write_text(day() / "calib_imu_to_velo.txt", kImu);
    write_camera("image_00", 1242, 375);
    write_camera("image_01", 1242, 375);
    write_oxts(100);
  }
  [[nodiscard]] fs::path day() const { return root_.path() / "2011_09_26"; }
  [[nodiscard]] fs::path drive() const { return day() / "2011_09_26_drive_0001_sync"; }
  [[nodiscard]] Recording read() const { return read_recording(drive()); }

  /// Three images at 10 Hz.
  void write_camera(const std::string& name, int width, int height) const {
    write_text(
        drive() / name / "timestamps.txt",
        "2011-09-26 13:02:25.964389445\n2011-09-26 13:02:26.064389445\n2011-09-26 13:02:26.164389445\n");
    for (const char* file : {"0000000000.png", "0000000001.png", "0000000002.png"}) {
      write_text(drive() / name / "data" / file, png_header(width, height));
    }
  }
  /// A car that drives east at 10 m/s, every so many milliseconds.
  void write_oxts(int interval_ms) const {
    fs::remove_all(drive() / "oxts");
    constexpr double kMetresPerDegree = 6'378'137.0 * 3.14159265358979 / 180.0 * 0.6560590289905073;  // at 49
    std::string times;
    for (int k = 0; k * interval_ms <= 300; ++k) {
      const int ms = 900 + k * interval_ms;
      times += "2011-09-26 13:02:" + std::to_string(25 + ms / 1000) + "." +
               std::to_string(1000 + ms % 1000).substr(1) + "000000\n";
      std::ostringstream row;
      row << std::setprecision(14) << "49.0 " << 8.0 + 0.01 * interval_ms * k / kMetresPerDegree
          << " 116.5 0 0 0 0 10 10 0 0 0.1 0.2 9.8 0.1 0.2 9.8 0.01 0.02 0.03 0.01 0.02 0.03 0.05 0.01 4 10 "
             "4 4 "
             "0\n";
      const std::string name = std::to_string(10'000'000'000LL + k).substr(1);
      write_text(drive() / "oxts" / "data" / (name + ".txt"), row.str());
    }
    write_text(drive() / "oxts" / "timestamps.txt", times);
  }

 private:
  TemporaryFolder root_;
};

TEST_F(RawDrive, IsReadWithRectifiedImagesAndTheTruthOfTheLeftCamera) {
  const Recording recording = read();
  ASSERT_EQ(recording.images.size(), 3u);
  EXPECT_EQ(recording.images[0].t_ns, 1'317'042'145'964'389'445);
  EXPECT_EQ(recording.images[2].cam1, drive() / "image_01/data/0000000002.png");
  EXPECT_EQ(recording.calibration.body, BodyFrame::kCam0);
  EXPECT_EQ(recording.calibration.cam0.width, 1242);
  EXPECT_NEAR(recording.calibration.theta(3), -387.5744 / 721.5377, 1e-9);
  EXPECT_TRUE(recording.imu.empty()) << "10 Hz";
  EXPECT_THAT(recording.notes, Contains(HasSubstr("too slow for an IMU")));
  EXPECT_THAT(recording.notes, Contains(HasSubstr("rectified, by their size of 1242 x 375")));
  ASSERT_EQ(recording.truth.motion.states.size(), 4u);
  const GroundTruthState &first = recording.truth.motion.states.front(),
                         &last = recording.truth.motion.states.back();
  EXPECT_NEAR((last.p_world_body - first.p_world_body).x(), 3.0, 1e-3) << "east";
  EXPECT_LT((first.R_world_body.col(2) - Eigen::Vector3d::UnitX()).norm(), 0.03) << "the camera looks ahead";
  EXPECT_LT((first.R_world_body.col(1) + Eigen::Vector3d::UnitZ()).norm(), 0.03) << "its y goes down";
  // KITTI's drawing: the camera is 0.27 + 0.81 m ahead of the IMU and 0.32 m beside it.
  EXPECT_NEAR(first.p_world_body.x(), 1.08, 0.03);
  EXPECT_NEAR(first.p_world_body.y(), -0.32, 0.03);
}

TEST_F(RawDrive, WithoutSomeImagesIsReadAndWithoutMostRefused) {
  fs::remove(drive() / "image_00/data/0000000000.png");
  EXPECT_EQ(read().images.size(), 3u);
  fs::remove(drive() / "image_01/data/0000000002.png");
  const DataError error = data_error_of([this] { static_cast<void>(read()); });
  EXPECT_EQ(error.file(), (drive() / "image_00/data/0000000000.png").string());
  EXPECT_THAT(error.what(),
              HasSubstr("expected an image for each time in timestamps.txt, found no such file"));
}

TEST_F(RawDrive, WithRawImagesAndAFastImuHasTheImuAsBody) {
  write_camera("image_00", 1392, 512);
  write_camera("image_01", 1392, 512);
  write_oxts(10);
  const Recording recording = read();
  EXPECT_EQ(std::get<Rational>(recording.calibration.cam1.distortion).k3, -5.314062e-02);
  EXPECT_EQ(recording.calibration.body, BodyFrame::kImu);
  ASSERT_EQ(recording.imu.size(), 31u);
  EXPECT_EQ(recording.imu[1].t_ns - recording.imu[0].t_ns, 10'000'000);
  EXPECT_EQ(recording.imu[0].omega_imu, Eigen::Vector3d(0.01, 0.02, 0.03));
  EXPECT_EQ(recording.imu[0].accel_imu, Eigen::Vector3d(0.1, 0.2, 9.8));
  EXPECT_EQ(recording.truth.motion.states.front().p_world_body, Eigen::Vector3d(0, 0, 0));
  EXPECT_NEAR(recording.calibration.T_body_cam0.p.x(), 1.08, 0.03);
  EXPECT_NEAR(recording.calibration.theta(3), -0.537, 0.02);
  EXPECT_THAT(recording.notes, Contains(HasSubstr("raw, by their size of 1392 x 512")));
}

TEST_F(RawDrive, InColourAloneHasTheLeftColourCameraAsBody) {
  fs::rename(drive() / "image_00", drive() / "image_02");
  fs::rename(drive() / "image_01", drive() / "image_03");
  const Recording recording = read();
  EXPECT_NEAR(recording.calibration.theta(3), -(339.5242 + 44.85728) / 721.5377, 2e-3);
  // cam2 stands 6 cm to the left of cam0.
  EXPECT_NEAR(recording.truth.motion.states.front().p_world_body.y(), -0.32 + 0.06, 0.03);
}

TEST_F(RawDrive, WithoutThePlaceOfTheImuIsReadByImages) {
  fs::remove(day() / "calib_imu_to_velo.txt");
  const Recording recording = read();
  EXPECT_TRUE(recording.truth.motion.states.empty());
  EXPECT_THAT(recording.notes, Contains(HasSubstr("without calib_imu_to_velo.txt")));
}

TEST_F(RawDrive, HasItsCalibrationBesideItToo) {
  fs::rename(day() / "calib_cam_to_cam.txt", drive() / "calib_cam_to_cam.txt");
  EXPECT_EQ(read().images.size(), 3u);
  fs::remove(drive() / "calib_cam_to_cam.txt");
  EXPECT_THAT(data_error_of([&] { (void)read(); }).what(), HasSubstr("_calib.zip"));
}

TEST_F(RawDrive, IsAskedForWhereTheDayIsGiven) {
  EXPECT_THAT(data_error_of([&] { (void)read_recording(day()); }).what(),
              HasSubstr("give one of them, " + drive().string()));
}

TEST_F(RawDrive, ThatDoesNotFitIsRefusedWithTheLine) {
  write_camera("image_00", 640, 480);
  EXPECT_THAT(data_error_of([&] { (void)read(); }).what(),
              HasSubstr("1242 x 375 (rectified) or 1392 x 512 (raw) pixels, found 640 x 480"));
  write_camera("image_00", 1242, 375);
  const fs::path times = drive() / "image_01" / "timestamps.txt";
  for (const auto& [text, line, words] :
       std::initializer_list<std::tuple<const char*, std::size_t, const char*>>{
           {"2011-09-26 13:02:25.9\n", 0, "3 times, as on the left"},
           {"2011-13-26 13:02:25.9\n", 1, "a time like 2011-09-26"},
           {"2011-09-26 25:02:25.9\n", 1, "a time like 2011-09-26"},
           {"2011-09-26\n", 1, "2 columns"},
           {"2011-09-26 13:02:25.96\n2011-09-26 13:02:26.06\n2011-09-26 13:02:26.26\n", 3,
            "of the left image"}}) {
    write_text(times, text);
    const DataError error = data_error_of([&] { (void)read(); });
    EXPECT_EQ(error.line(), line) << text;
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
}

TEST_F(RawDrive, WhoseBytesFlippedIsReadOrRefused) {
  const fs::path files[] = {day() / "calib_cam_to_cam.txt", day() / "calib_imu_to_velo.txt",
                            drive() / "image_00/timestamps.txt", drive() / "oxts/timestamps.txt",
                            drive() / "oxts/data/0000000001.txt"};
  const RandomStream random(1, 0, "raw drive");
  for (std::uint64_t i = 0; i < 200; ++i) {
    const fs::path& file = files[i % std::size(files)];
    const std::string sound = read_text(file);
    std::string other = sound;
    for (std::uint32_t k = 0; k < 1 + i % 4; ++k) {
      const auto at = static_cast<std::size_t>(random.uniform(i, 2 * k) * static_cast<double>(other.size()));
      other[at] = static_cast<char>(256.0 * random.uniform(i, 2 * k + 1));
    }
    write_text(file, i % 7 == 0 ? other.substr(0, other.size() / 2) : other);
    try {
      (void)read();
    } catch (const DataError& error) {
      EXPECT_FALSE(error.file().empty());
    } catch (const std::exception& error) {
      ADD_FAILURE() << file << ", mutation " << i << ": " << error.what();
    }
    write_text(file, sound);
  }
}

}  // namespace
}  // namespace limber
