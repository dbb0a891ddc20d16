// SPDX-License-Identifier: MIT
// EuRoC folders with images, made by hand: file headers stand in for images.
#include <gtest/gtest.h>

#include "files.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/rig_files/write_rig_files.hpp"
#include "small_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::data_error_of;
using testing::png_header;
using testing::TemporaryFolder;
using testing::write_text;

// Three frames per camera, the middle ones of different times.
class EurocFolder : public ::testing::Test {
 protected:
  EurocFolder() {
    write_track_log(testing::small_recording(), folder_.path());
    fs::remove_all(mav0() / "tracks0");
    write_text(mav0() / "cam0/data.csv",
               "#timestamp [ns],filename\r\n1000,1000.png\r\n1999,1999.png\r\n3000,3000.png\r\n");
    write_text(mav0() / "cam1/data.csv",
               "#timestamp [ns],filename\n1000,1000.png\n2001,2001.png\n3000,3000.png\n4000,4000.png\n");
    for (const char* const name :
         {"cam0/data/1000.png", "cam0/data/3000.png", "cam1/data/1000.png", "cam1/3000.png"}) {
      write_text(mav0() / name, png_header(752, 480));
    }
  }
  [[nodiscard]] fs::path mav0() const { return folder_.path() / "mav0"; }
  [[nodiscard]] Recording read() const { return read_recording(folder_.path()); }
  [[nodiscard]] DataError error() const {
    return data_error_of([this] { static_cast<void>(read()); });
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(EurocFolder, GivesPairsOfEqualTimeAndNotesTheOthers) {
  const Recording recording = read();
  ASSERT_EQ(recording.images.size(), 2U);
  EXPECT_EQ(recording.images[0].t_ns, 1000);
  EXPECT_EQ(recording.images[1].t_ns, 3000);
  EXPECT_EQ(recording.images[1].cam0, mav0() / "cam0/data/3000.png");
  EXPECT_EQ(recording.images[1].cam1, mav0() / "cam1/3000.png") << "beside data.csv";
  EXPECT_TRUE(recording.frames.empty());
  EXPECT_EQ(recording.imu.size(), 4U);
  ASSERT_EQ(recording.notes.size(), 1U);
  EXPECT_NE(recording.notes[0].find("1 images of cam0 and 2 of cam1"), std::string::npos)
      << recording.notes[0];
}

TEST_F(EurocFolder, MayHaveKalibrsFilesBesideItAsTumViHas) {
  const Recording own = read();
  const fs::path dso = mav0().parent_path() / "dso";
  write_text(dso / "camchain.yaml", kalibr_camchain(own.calibration));
  write_text(dso / "imu_config.yaml", kalibr_imu(ImuNoise{1e-4, 2e-5, 3e-3, 4e-4}));
  for (const char* const sensor : {"cam0", "cam1", "imu0"}) {
    fs::remove(mav0() / sensor / "sensor.yaml");
  }
  fs::rename(mav0() / "state_groundtruth_estimate0", mav0() / "mocap0");
  const Recording recording = read();
  EXPECT_LE((recording.calibration.theta - own.calibration.theta).norm(), 1e-12);
  EXPECT_EQ(recording.calibration.body, BodyFrame::kImu);
  EXPECT_TRUE(recording.calibration.T_body_cam0.p.isApprox(own.calibration.T_body_cam0.p, 1e-12));
  EXPECT_EQ(recording.calibration.cam1.width, 752);
  EXPECT_EQ(recording.imu_noise->accel_density, 3e-3);
  EXPECT_EQ(recording.truth.motion.states.size(), own.truth.motion.states.size());
  fs::remove(dso / "camchain.yaml");
  EXPECT_NE(std::string(error().what()).find("cam0/sensor.yaml"), std::string::npos);
}

TEST_F(EurocFolder, MayHoldJpegs) {
  const auto jpeg = [](int width, int height) {
    std::string text("\xff\xd8\xff\xe0\0\4ab\xff\xdb\0\3c\xff\xc0\0\x0b\x08", 18);
    for (const int side : {height, width}) {
      text += static_cast<char>(side >> 8);
      text += static_cast<char>(side & 0xff);
    }
    return text;
  };
  write_text(mav0() / "cam0/data.csv", "#timestamp [ns],filename\n1000,a.jpg\n");
  write_text(mav0() / "cam0/data/a.jpg", jpeg(752, 480));
  EXPECT_EQ(read().images[0].cam0.filename(), "a.jpg");
  write_text(mav0() / "cam0/data/a.jpg", jpeg(640, 480));
  EXPECT_NE(std::string(error().what()).find("752 x 480 pixels, as sensor.yaml says, found 640 x 480"),
            std::string::npos)
      << error().what();
}

TEST_F(EurocFolder, KeepsAPairWithoutItsImageWhichCostsTheFrame) {
  fs::remove(mav0() / "cam1/3000.png");
  EXPECT_EQ(read().images.size(), 2U);
  fs::create_directory(mav0() / "cam1/data/3000.png");
  EXPECT_EQ(read().images.size(), 2U);
}

TEST_F(EurocFolder, NamesTheFirstMissingImageAndItsLineWhereMostAreMissing) {
  fs::remove(mav0() / "cam0/data/1000.png");
  fs::remove(mav0() / "cam1/data/1000.png");
  fs::remove(mav0() / "cam1/3000.png");
  EXPECT_EQ(error().file(), (mav0() / "cam0/data.csv").string());
  write_text(mav0() / "cam0/data/1000.png", png_header(752, 480));
  write_text(mav0() / "cam1/data.csv", "#timestamp [ns],filename\n2001,2001.png\n3000,3000.png\n");
  const DataError e = error();
  EXPECT_EQ(e.file(), (mav0() / "cam1/data.csv").string());
  EXPECT_EQ(e.line(), 3U);
  EXPECT_NE(std::string(e.what()).find("the image 3000.png"), std::string::npos) << e.what();
}

TEST_F(EurocFolder, RefusesImagesThatDoNotFitTheCalibration) {
  write_text(mav0() / "cam1/data/1000.png", png_header(640, 512));
  EXPECT_EQ(error().file(), (mav0() / "cam1/data/1000.png").string());
}

TEST_F(EurocFolder, GoesByTheSizeOfMostImages) {
  std::string list = "#timestamp [ns],filename\n";
  for (int k = 1; k <= 9; ++k) {
    list += std::to_string(1000 * k) + ",a" + std::to_string(k) + ".png\n";
    for (const char* const camera : {"cam0/data", "cam1/data"}) {
      write_text(mav0() / camera / ("a" + std::to_string(k) + ".png"), k == 1 ? "" : png_header(752, 480));
    }
  }
  write_text(mav0() / "cam0/data.csv", list);
  write_text(mav0() / "cam1/data.csv", list);
  write_text(mav0() / "cam1/data/a2.png", png_header(376, 240));
  EXPECT_EQ(read().images.size(), 9U);
  for (int k = 3; k <= 6; ++k) {
    write_text(mav0() / "cam1/data" / ("a" + std::to_string(k) + ".png"), png_header(376, 240));
  }
  const DataError e = error();
  EXPECT_EQ(e.file(), (mav0() / "cam1/data/a2.png").string());
  EXPECT_NE(std::string(e.what()).find("found 376 x 240"), std::string::npos) << e.what();
}

TEST_F(EurocFolder, RefusesAnImageThatIsNone) {
  fs::remove(mav0() / "cam0/data/3000.png");
  write_text(mav0() / "cam0/data/1000.png", "not a picture");
  EXPECT_NE(std::string(error().what()).find("a PNG, JPEG, TIFF, PGM or PPM image"), std::string::npos);
  write_text(mav0() / "cam0/data/1000.png", png_header(752, 480).substr(0, 20));
  EXPECT_NE(std::string(error().what()).find("a PNG, JPEG, TIFF, PGM or PPM image"), std::string::npos);
}

TEST_F(EurocFolder, RefusesCamerasWithoutACommonTime) {
  write_text(mav0() / "cam1/data.csv", "#timestamp [ns],filename\n1001,1000.png\n");
  EXPECT_NE(std::string(error().what()).find("timestamps that cam0/data.csv has too"), std::string::npos);
}

TEST_F(EurocFolder, RefusesTimesThatDoNotIncrease) {
  write_text(mav0() / "cam1/data.csv", "#timestamp [ns],filename\n3000,3000.png\n1000,1000.png\n");
  EXPECT_EQ(error().line(), 3U);
}

TEST_F(EurocFolder, RefusesAnEmptyListOfImages) {
  write_text(mav0() / "cam0/data.csv", "#timestamp [ns],filename\n");
  EXPECT_NE(std::string(error().what()).find("at least one image"), std::string::npos);
}

TEST_F(EurocFolder, GivesWayToMatchedPointsBesideTheImages) {
  write_text(mav0() / "tracks0/data.csv", "1000,1,2,3,4,5\n");
  const Recording recording = read();
  EXPECT_EQ(recording.frames.size(), 1U);
  EXPECT_TRUE(recording.images.empty());
  EXPECT_NE(recording.notes.back().find("images are not used"), std::string::npos);
}

}  // namespace
}  // namespace limber
