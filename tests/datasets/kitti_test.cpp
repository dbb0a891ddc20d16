// SPDX-License-Identifier: MIT
// KITTI odometry folders, made by hand: PNG headers stand in for images.
#include <gtest/gtest.h>

#include "files.hpp"
#include "limber/datasets/read_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::data_error_of;
using testing::png_header;
using testing::TemporaryFolder;
using testing::write_text;

const char* const kCalibration =
    "P0: 7.0e+02 0 6.0e+02 0 0 7.1e+02 1.8e+02 0 0 0 1 0\n"
    "P1: 7.0e+02 0 6.1e+02 -3.5e+02 0 7.1e+02 1.8e+02 0 0 0 1 0\n"
    "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";
// The second pose: 2 m ahead, 1 m up, turned to the left by 90 degrees (about -y of the camera).
const char* const kPoses = "1 0 0 0 0 1 0 0 0 0 1 0\n0 0 -1 0 0 1 0 -1 1 0 0 2\n";

class KittiFolder : public ::testing::Test {
 protected:
  KittiFolder() {
    write_text(folder() / "calib.txt", kCalibration);
    write_text(folder() / "times.txt", "0.000000e+00\n1.045055e-01\n");
    write_text(folder() / "poses.txt", kPoses);
    for (const char* const name :
         {"image_0/000000.png", "image_0/000001.png", "image_1/000000.png", "image_1/000001.png"}) {
      write_text(folder() / name, png_header(1226, 370));
    }
  }
  [[nodiscard]] fs::path folder() const { return root_.path() / "sequences" / "06"; }
  [[nodiscard]] fs::path root() const { return root_.path(); }
  [[nodiscard]] Recording read() const { return read_recording(folder()); }
  void expect_error(const std::string& file, std::size_t line, const std::string& words) const {
    const DataError error = data_error_of([this] { static_cast<void>(read()); });
    EXPECT_EQ(error.file(), (folder() / file).string()) << error.what();
    EXPECT_EQ(error.line(), line) << error.what();
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }

 private:
  TemporaryFolder root_;
};

TEST_F(KittiFolder, InColourHasTheLeftColourCameraAsBodyAndItsPosesAreThere) {
  fs::rename(folder() / "image_0", folder() / "image_2");
  fs::rename(folder() / "image_1", folder() / "image_3");
  write_text(folder() / "calib.txt", std::string(kCalibration) +
                                         "P2: 7.0e+02 0 6.0e+02 4.2e+01 0 7.1e+02 1.8e+02 0 0 0 1 0\n"
                                         "P3: 7.0e+02 0 6.0e+02 -3.5e+02 0 7.1e+02 1.8e+02 0 0 0 1 0\n");
  const Recording recording = read();
  EXPECT_EQ(recording.images[1].cam0, folder() / "image_2/000001.png");
  EXPECT_EQ(recording.images[1].cam1, folder() / "image_3/000001.png");
  EXPECT_NEAR(recording.calibration.theta(3), -0.56, 1e-12);
  // cam2 stands 6 cm to the left of cam0: y of a world that the camera looks into along x.
  EXPECT_LE((recording.truth.motion.states[0].p_world_body - Eigen::Vector3d(0, 0.06, 0)).norm(), 1e-12);
}

TEST_F(KittiFolder, GivesTheRectifiedRigWithTheLeftCameraAsBody) {
  const Recording recording = read();
  const StereoCalibration& calibration = recording.calibration;
  EXPECT_EQ(recording.name, "06");
  EXPECT_EQ(calibration.body, BodyFrame::kCam0);
  EXPECT_EQ(calibration.T_body_cam0.R, Eigen::Matrix3d::Identity());
  EXPECT_EQ(calibration.cam0.fu, 700.0);
  EXPECT_EQ(calibration.cam1.fv, 710.0);
  EXPECT_EQ(calibration.cam0.cu, 600.0);
  EXPECT_EQ(calibration.cam1.cu, 610.0);
  EXPECT_EQ(calibration.cam1.width, 1226);
  EXPECT_EQ(calibration.cam0.height, 370);
  RigParameters theta;
  theta << 0, 0, 0, -0.5, 0, 0;
  EXPECT_LE((calibration.theta - theta).norm(), 1e-15);
}

TEST_F(KittiFolder, GivesTimesToTheNanosecond) {
  const Recording recording = read();
  ASSERT_EQ(recording.images.size(), 2U);
  EXPECT_EQ(recording.images[0].t_ns, 0);
  EXPECT_EQ(recording.images[1].t_ns, 104505500);
  EXPECT_EQ(recording.images[1].cam1, folder() / "image_1/000001.png");
}

TEST_F(KittiFolder, HasItsTruthInAWorldWithZUp) {
  const Recording recording = read();
  ASSERT_EQ(recording.truth.motion.states.size(), 2U);
  EXPECT_FALSE(recording.truth.motion.has_velocity);
  const GroundTruthState& first = recording.truth.motion.states[0];
  EXPECT_LE((first.R_world_body.col(2) - Eigen::Vector3d(1, 0, 0)).norm(), 1e-15) << "looks along x";
  EXPECT_LE((first.R_world_body.col(1) - Eigen::Vector3d(0, 0, -1)).norm(), 1e-15)
      << "image down is world down";
  const GroundTruthState& second = recording.truth.motion.states[1];
  EXPECT_EQ(second.t_ns, 104505500);
  EXPECT_LE((second.p_world_body - Eigen::Vector3d(2, 0, 1)).norm(), 1e-15);
  EXPECT_LE((second.R_world_body.col(2) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-15) << "turned to the left";
}

TEST_F(KittiFolder, FindsThePosesInKittisOwnLayout) {
  fs::remove(folder() / "poses.txt");
  EXPECT_TRUE(read().truth.motion.states.empty());
  write_text(root() / "poses" / "06.txt", kPoses);
  EXPECT_EQ(read().truth.motion.states.size(), 2U);
}

TEST_F(KittiFolder, NamesWhatIsMissing) {
  fs::remove(folder() / "image_1/000001.png");
  EXPECT_EQ(read().images.size(), 2U) << "costs its frame";
  fs::remove(folder() / "image_1/000000.png");
  write_text(folder() / "image_1/000001.png", png_header(1226, 370));
  EXPECT_EQ(read().calibration.cam1.width, 1226) << "by the other one";
  fs::remove(folder() / "image_1/000001.png");
  write_text(folder() / "times.txt", "0.0\n");
  fs::remove(folder() / "image_0/000001.png");
  expect_error("image_1/000000.png", 0, "an image for each of the 1 times in times.txt, found no such file");
  write_text(folder() / "image_1/000000.png", png_header(1226, 370));
  write_text(folder() / "times.txt", "0.0\n0.1\n0.2\n");
  expect_error("image_0/000001.png", 0, "no such file");
  fs::remove(folder() / "times.txt");
  expect_error("times.txt", 0, "no such file");
}

TEST_F(KittiFolder, NeedsItsCalibration) {
  fs::remove(folder() / "calib.txt");
  expect_error("calib.txt", 0, "no such file");
}

TEST_F(KittiFolder, NeedsATimeForEachImage) {
  write_text(folder() / "times.txt", "0.0\n");
  expect_error("times.txt", 0, "a time for each image");
}

TEST_F(KittiFolder, RefusesTimesThatAreNoneOrDoNotIncrease) {
  write_text(folder() / "times.txt", "0.0\n0.1s\n");
  expect_error("times.txt", 2, "a time in seconds, found '0.1s'");
  write_text(folder() / "times.txt", "0.5\n0.4\n");
  expect_error("times.txt", 2, "later than the previous one");
}

TEST_F(KittiFolder, RefusesPosesThatDoNotFit) {
  write_text(folder() / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_error("poses.txt", 0, "2 poses, one for each image pair, found 1");
  write_text(folder() / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0\n");
  expect_error("poses.txt", 2, "12 columns");
  write_text(folder() / "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n2 0 0 0 0 1 0 0 0 0 1 0\n");
  expect_error("poses.txt", 2, "a rotation");
}

TEST_F(KittiFolder, RefusesACalibrationThatIsNone) {
  const auto calibrate = [this](const std::string& from, const std::string& to) {
    write_text(folder() / "calib.txt", testing::replaced(kCalibration, from, to));
  };
  calibrate("P1:", "P7:");
  expect_error("calib.txt", 0, "a line that starts with P1:");
  calibrate("P1:", "P0:");
  expect_error("calib.txt", 2, "every label once");
  calibrate("-3.5e+02", "3.5e+02");
  expect_error("calib.txt", 2, "are P0 and P1 swapped?");
  calibrate("-3.5e+02", "0");
  expect_error("calib.txt", 2, "a baseline of zero");
  calibrate("7.0e+02", "-7.0e+02");
  expect_error("calib.txt", 1, "positive focal lengths");
  calibrate("7.0e+02 0 6.0e+02", "7.0e+02 0.1 6.0e+02");
  expect_error("calib.txt", 1, "a rectified projection");
  calibrate("7.0e+02", "seven");
  expect_error("calib.txt", 1, "a finite number in P0:, found 'seven'");
  calibrate("-3.5e+02 0", "");
  expect_error("calib.txt", 2, "P1: with 12 numbers");
}

}  // namespace
}  // namespace limber
