// SPDX-License-Identifier: MIT
// Every way in which a recording can be broken ends in a DataError that names file, line, expected and found.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

#include "edits.hpp"
#include "files.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "small_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::append;
using testing::cut_end;
using testing::data_error_of;
using testing::Edit;
using testing::header_only;
using testing::read_text;
using testing::replace;
using testing::replace_between;
using testing::small_recording;
using testing::TemporaryFolder;
using testing::write_text;

struct BadFile {
  const char* name;
  const char* file;
  Edit edit;
  std::size_t line;   // 0: the whole file
  const char* words;  // in the message
};

// The small recording's first time, and its line in every data.csv, is 2; frames have the lines 2, 3; 4; 5.
const char* const kT0 = "1317384506402996993";
const char* const kT1 = "1317384506452996994";
const char* const kT2 = "1317384506502996995";
const char* const kCam1 = "cam1/sensor.yaml";
const char* const kTracks = "tracks0/data.csv";
const char* const kTruth = "state_groundtruth_estimate0/data.csv";

std::vector<BadFile> bad_files() {
  const std::string identity = "1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1";
  return {
      {"TrackWithNan", kTracks, replace("20.5", "nan"), 3, "finite number for u0 [px], found 'nan'"},
      {"TrackColumnsInAnotherOrder", kTracks, replace("u0 [px],v0 [px],u1 [px],v1 [px]", "u1,v1,u0,v0"), 1,
       "expected the columns timestamp [ns], track_id, u0 [px], v0 [px], u1 [px], v1 [px], found u1 as "
       "column 3"},
      {"ImuColumnsInAnotherOrder", "imu0/data.csv",
       replace("w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1]", "w_RS_S_y [rad s^-1],w_RS_S_x [rad s^-1]"), 1,
       "found w_RS_S_y [rad s^-1] as column 2"},
      {"TruthWithTheScalarLast", kTruth,
       replace("q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []", "q_RS_x [],q_RS_y [],q_RS_z [],q_RS_w []"), 1,
       "found q_RS_x [] as column 5"},
      {"TrackWithInfinity", kTracks, replace("20.5", "-inf"), 3, "found '-inf'"},
      {"TrackFarOutsideTheImage", kTracks, replace("20.5", "1e308"), 3,
       "u0 [px] within ±7520, found '1e308'"},
      {"TrackThatOverflows", kTracks, replace("20.5", "1e999"), 3, "found '1e999'"},
      {"TrackWithLetters", kTracks, replace("30.25", "30.25px"), 3,
       "finite number for v0 [px], found '30.25px'"},
      {"TrackIdWithFraction", kTracks, replace(",-3,", ",3.5,"), 3, "an integer for track_id, found '3.5'"},
      {"TimeInSeconds", kTracks, replace(kT0, "1317384506.4"), 2,
       "an integer for timestamp [ns] (nanoseconds; is this in seconds?), found '1317384506.4'"},
      {"TimeBeyond64Bits", kTracks, replace(kT0, "99999999999999999999"), 2, "an integer for timestamp [ns]"},
      {"TimeNear64Bits", kTracks, replace(kT0, "9223372036854775807"), 2, "a timestamp between"},
      {"FrameTimesBackwards", kTracks, replace(kT2, "1317384506402996000"), 5,
       "later than the previous one ("},
      {"EmptyFrameTwice", kTracks, replace(kT2 + std::string(",7,,,90,"), kT1 + std::string(",7,,,90,")), 5,
       "found the same timestamp again"},
      {"EmptyLineInAFullFrame", kTracks, replace(kT1, kT0), 4, "found the same timestamp again"},
      {"PointTwiceInAFrame", kTracks, replace(",-3,", ",7,"), 3,
       "every track_id once in a frame, found 7 again"},
      {"PointWithoutPixels", kTracks, replace("20.5,30.25", ","), 3, "pixels in at least one camera"},
      {"PointWithHalfAPixel", kTracks, replace("20.5,30.25", "20.5,"), 3,
       "finite number for v0 [px], found ''"},
      {"PointWithoutId", kTracks, replace(",-3,", ",,"), 3, "an integer for track_id, found ''"},
      {"TooFewColumns", kTracks, replace(",20.5", ""), 3, "6 columns (timestamp [ns], track_id, u0 [px]"},
      {"TooManyColumns", kTracks, replace("20.5,", "20.5,1,"), 3, "found 7"},
      {"HalfALastLine", kTracks, cut_end(35), 5, "and the file ends within this line"},
      {"TracksWithHeaderOnly", kTracks, header_only(), 0, "at least one frame, found none"},
      {"TracksEmpty", kTracks, [](const std::string&) { return std::string(); }, 0, "at least one frame"},
      {"TracksBinary", kTracks, append(std::string("\x01\x02\0\xff", 4)), 6,
       "text, found binary data (byte 0x01)"},
      {"TracksGarbage", kTracks, append("\xc3\xa4\xff\xfe\n"), 6, "6 columns"},
      {"ImuTimesBackwards", "imu0/data.csv", replace(kT1, "1317384506402996992"), 3,
       "later than the previous one"},
      {"ImuTimeTwice", "imu0/data.csv", replace(kT1, kT0), 3, "found the same timestamp again"},
      {"ImuShortRow", "imu0/data.csv", append("1317384506952996994,1,2,3\n"), 6, "7 columns"},
      {"ImuWithHeaderOnly", "imu0/data.csv", header_only(), 0, "at least one IMU sample"},
      {"ImuElsewhere", "imu0/sensor.yaml", replace("data: [1, 0, 0, 0,", "data: [1, 0, 0, 0.1,"), 3,
       "the IMU must be in the body frame"},
      {"ImuRateOfNoGyro", "imu0/data.csv",
       replace(kT0 + std::string(","), kT0 + std::string(",1e200,0,0,0,0,0\n#")), 2,
       "w_x within ±10000, found '1e200'"},
      {"ImuNoiseHuge", "imu0/sensor.yaml", replace("_random_walk: ", "_random_walk: 1e200 #"), 7,
       "at most 1000000, found 1e+200"},
      {"ImuNoiseNegative", "imu0/sensor.yaml", replace("_random_walk: ", "_random_walk: -"), 7,
       "of zero or more"},
      {"ImuNoiseNoNumber", "imu0/sensor.yaml", replace("_random_walk: ", "_random_walk: x"), 7,
       "a finite number"},
      {"OdometryNan", "odometry0/data.csv", replace("1e-300", "nan"), 2, "a finite number for w_x"},
      {"OdometrySigmaShort", "odometry0/sensor.yaml", replace("sigma_v: [0.1, ", "sigma_v: ["), 1,
       "sigma_v as a list of 3 numbers, found a list of 2"},
      {"OdometrySigmaNegative", "odometry0/sensor.yaml", replace("[0.1, ", "[-0.1, "), 1, "of zero or more"},
      {"PixelSigmaZero", "tracks0/sensor.yaml", replace("0.5, ", "0, "), 1, "sigma_px above zero"},
      {"TruthWith9Columns", kTruth, [](const std::string&) { return std::string("1,0,0,0,1,0,0,0,0\n"); }, 1,
       "8, 11 or 17 columns"},
      {"TruthChangesColumns", kTruth,
       [](const std::string&) { return std::string("1,0,0,0,1,0,0,0\n2,0,0,0,1,0,0,0,0,0,0\n"); }, 2,
       "8 columns"},
      {"TruthQuaternionFarFromUnit", kTruth,
       [](const std::string&) { return std::string("1,0,0,0,1,0,0,0\n2,0,0,0,1,0.5,0,0\n"); }, 2,
       "a unit quaternion, found one of norm 1.118"},
      {"TruthQuaternionZero", kTruth, [](const std::string&) { return std::string("1,0,0,0,0,0,0,0\n"); }, 1,
       "found one of norm 0"},
      {"TruthTimesTwice", kTruth,
       [](const std::string&) { return std::string("5,0,0,0,1,0,0,0\n5,0,0,0,1,0,0,0\n"); }, 2,
       "same timestamp"},
      {"LandmarkTwice", "landmarks0/data.csv", append("100,1,2,3\n"), 6,
       "every track_id once, found 100 again"},
      {"CalibrationTruthNan", "calibration_truth0/data.csv", replace("0.01", "NaN"), 2,
       "number for ax [rad]"},
      {"UnknownCameraModel", kCam1, replace("pinhole", "fov"), 7,
       "camera_model pinhole or omni, found 'fov'"},
      {"UnknownDistortion", kCam1, replace("equidistant", "fov"), 9, "found 'fov'"},
      {"TooFewCoefficients", kCam1, replace("_coefficients: [0.01, ", "_coefficients: ["), 10,
       "found a list of 3"},
      {"CoefficientsWithoutDistortion", kCam1, replace("equidistant", "none"), 10, "a list of 0 numbers"},
      {"NoCoefficients", kCam1, replace("distortion_coefficients", "coefficients"), 0,
       "the key distortion_coefficients"},
      {"NoCameraModel", kCam1, replace("camera_model", "model"), 0,
       "the key camera_model, found no such key"},
      {"FocalLengthZero", kCam1, replace("457.587", "0"), 8,
       "positive focal lengths fu, fv [px], 0.001 to 1000000, found 0 and 456"},
      {"FocalLengthTiny", kCam1, replace("456.134", "1e-200"), 8, "positive focal lengths"},
      {"FocalLengthHuge", kCam1, replace("456.134", "1e200"), 8, "positive focal lengths"},
      {"FocalLengthNegative", kCam1, replace("456.134", "-456"), 8, "positive focal lengths"},
      {"FocalLengthNan", kCam1, replace("456.134", ".nan"), 8, "a finite number in intrinsics, found '.nan'"},
      {"ThreeIntrinsics", kCam1, replace("457.587, ", ""), 8, "intrinsics as a list of 4 numbers"},
      {"ResolutionZero", kCam1, replace("[752, ", "[0, "), 6, "positive whole numbers"},
      {"ResolutionFraction", kCam1, replace("[752, ", "[752.5, "), 6, "positive whole numbers"},
      {"ResolutionEndless", kCam1, replace("[752, ", "[1e30, "), 6, "positive whole numbers"},
      {"TbsMissing", kCam1, replace("T_BS", "T_SB"), 0, "the key T_BS"},
      {"TbsWithoutData", kCam1, replace("data:", "values:"), 3, "data: [16 numbers]"},
      {"TbsWith15Numbers", kCam1, replace_between("data: [", "]", identity.substr(3)), 5,
       "found a list of 15"},
      {"TbsThreeRows", kCam1, replace("rows: 4", "rows: 3"), 4, "4 rows in T_BS, found '3'"},
      {"TbsScaled", kCam1, replace_between("data: [", "]", "1.1" + identity.substr(1)), 3,
       "R^T R off by 0.21"},
      {"TbsMirrored", kCam1, replace_between("data: [", "]", "-" + identity), 3, "det R = -1"},
      {"TbsBottomRow", kCam1, replace_between("data: [", "]", identity.substr(0, identity.size() - 1) + "2"),
       3, "0 0 0 1 as the last row of T_BS, found 0 0 0 2"},
      {"TbsWithNan", kCam1, replace_between("data: [", "]", ".nan" + identity.substr(1)), 5,
       "a finite number in T_BS"},
      {"YamlSyntax", kCam1, replace("resolution: [752", "resolution: [752]]"), 6, "valid YAML"},
      {"YamlUnclosed", kCam1, replace_between("data: [", "]", identity + "\nresolution: {"), 6, "valid YAML"},
      {"YamlIsAList", kCam1, [](const std::string&) { return std::string("- a\n- b\n"); }, 0,
       "a YAML mapping"},
      {"YamlEmpty", kCam1, [](const std::string&) { return std::string(); }, 0,
       "a YAML mapping (key: value), found"},
      {"YamlBinary", kCam1,
       [](const std::string&) {
         return std::string(
             "\x7f"
             "ELF\0\1",
             6);
       },
       1, "binary data"},
  };
}

void PrintTo(const BadFile& bad, std::ostream* stream) { *stream << bad.name << " in " << bad.file; }

class BadInput : public ::testing::TestWithParam<BadFile> {};

TEST_P(BadInput, IsNamedWithFileAndLine) {
  const BadFile& bad = GetParam();
  const TemporaryFolder folder;
  write_track_log(small_recording(), folder.path());
  const fs::path file = folder.path() / "mav0" / bad.file;
  write_text(file, bad.edit(read_text(file)));
  const DataError error = data_error_of([&] { static_cast<void>(read_recording(folder.path())); });
  EXPECT_EQ(error.file(), file.string());
  EXPECT_EQ(error.line(), bad.line) << error.what();
  EXPECT_NE(std::string(error.what()).find(bad.words), std::string::npos) << error.what();
}

INSTANTIATE_TEST_SUITE_P(EachFile, BadInput, ::testing::ValuesIn(bad_files()),
                         [](const auto& test) { return std::string(test.param.name); });

// The log with T_BS of cam1 so that T_cam1_cam0 has this translation and no rotation.
std::string error_with_baseline(const Eigen::Vector3d& t) {
  const TemporaryFolder folder;
  Recording recording = small_recording();
  recording.calibration.theta << Eigen::Vector3d::Zero(), t;
  write_track_log(recording, folder.path());
  const DataError error = data_error_of([&] { static_cast<void>(read_recording(folder.path())); });
  EXPECT_EQ(error.file(), (folder.path() / "mav0/cam1/sensor.yaml").string());
  EXPECT_EQ(error.line(), 3U);
  return error.what();
}

TEST(Baseline, MustNotBeZero) {
  EXPECT_NE(error_with_baseline({0, 0, 0}).find("baseline of zero"), std::string::npos);
}

TEST(Baseline, MustNotHaveCam1ToTheLeft) {
  const std::string message = error_with_baseline({0.11, 0.001, 0});
  EXPECT_NE(message.find("swapped"), std::string::npos) << message;
  EXPECT_NE(message.find("inverted"), std::string::npos) << message;
}

TEST(Baseline, MustNotBeEndless) {
  EXPECT_NE(error_with_baseline({-1e200, 0, 0}).find("cameras less than 1000 m apart"), std::string::npos);
}

TEST(Baseline, MayBeVerticalButThenThereIsANote) {
  const TemporaryFolder folder;
  Recording recording = small_recording();
  recording.calibration.theta << 0, 0, 0, 0.01, 0.2, 0;
  write_track_log(recording, folder.path());
  const Recording actual = read_recording(folder.path());
  ASSERT_EQ(actual.notes.size(), 1U);
  EXPECT_NE(actual.notes[0].find("mainly along the y axis"), std::string::npos);
}

TEST(MissingInput, IsNamed) {
  for (const char* const file : {"cam0/sensor.yaml", "cam1/sensor.yaml", "imu0/data.csv", "tracks0/data.csv",
                                 "landmarks0/data.csv", "state_groundtruth_estimate0/data.csv"}) {
    const TemporaryFolder folder;
    write_track_log(small_recording(), folder.path());
    fs::remove(folder.path() / "mav0" / file);
    const DataError error = data_error_of([&] { static_cast<void>(read_recording(folder.path())); });
    EXPECT_EQ(error.file(), (folder.path() / "mav0" / file).string());
    EXPECT_NE(std::string(error.what()).find("found no such file"), std::string::npos) << error.what();
  }
}

TEST(MissingInput, IsAlsoAFolderInPlaceOfAFile) {
  const TemporaryFolder folder;
  write_track_log(small_recording(), folder.path());
  fs::remove(folder.path() / "mav0/imu0/data.csv");
  fs::create_directory(folder.path() / "mav0/imu0/data.csv");
  const DataError error = data_error_of([&] { static_cast<void>(read_recording(folder.path())); });
  EXPECT_NE(std::string(error.what()).find("not a file"), std::string::npos) << error.what();
}

TEST(MissingInput, ListsWhatWasLookedForInAStrangeFolder) {
  const TemporaryFolder folder;
  write_text(folder.path() / "README.md", "nothing to see");
  const DataError error = data_error_of([&] { static_cast<void>(read_recording(folder.path())); });
  EXPECT_EQ(error.file(), folder.path().string());
  for (const char* const words :
       {"mav0/tracks0", "mav0/cam0/data.csv", "image_0", "calib.txt", "times.txt"}) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << words;
  }
}

TEST(MissingInput, IsAPathThatIsNoFolder) {
  const TemporaryFolder folder;
  const fs::path file = write_text(folder.path() / "file", "text");
  EXPECT_NE(std::string(data_error_of([&] { static_cast<void>(read_recording(file)); }).what())
                .find("found a file"),
            std::string::npos);
  const fs::path nowhere = folder.path() / "nowhere";
  EXPECT_EQ(
      std::string(data_error_of([&] { static_cast<void>(read_recording(nowhere)); }).what()),
      nowhere.string() + ": expected the folder of a recording, or a bag, found no such file or folder");
}

// Reads a log whose files have been damaged: only success or DataError will do; anything else ends the test.
bool can_be_read(const fs::path& folder) {
  try {
    static_cast<void>(read_recording(folder));
    return true;
  } catch (const DataError& error) {
    EXPECT_FALSE(error.file().empty());
    return false;
  }
}

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

TEST(DamagedLog, CutAnywhereIsReadOrRefusedButNothingElse) {
  const TemporaryFolder folder;
  write_track_log(small_recording(), folder.path());
  int read = 0, refused = 0;
  for (const fs::path& file : files_of(folder.path())) {
    const std::string whole = read_text(file);
    for (std::size_t size = 0; size < whole.size(); size += 5) {
      write_text(file, whole.substr(0, size));
      (can_be_read(folder.path()) ? read : refused)++;
    }
    write_text(file, whole);
  }
  EXPECT_TRUE(can_be_read(folder.path()));
  EXPECT_GT(refused, 500);
  EXPECT_GT(read, 10);  // cut at the end of a line, or in an optional part
}

TEST(DamagedLog, WithRandomBytesIsReadOrRefusedButNothingElse) {
  const TemporaryFolder folder;
  write_track_log(small_recording(), folder.path());
  std::mt19937 random(20240607);
  int refused = 0;
  for (const fs::path& file : files_of(folder.path())) {
    const std::string whole = read_text(file);
    for (int trial = 0; trial < 100; ++trial) {
      std::string damaged = whole;
      for (int k = 0; k < 1 + trial % 4; ++k) {
        damaged[random() % damaged.size()] =
            static_cast<char>(trial % 2 == 0 ? random() : 0x20 + random() % 0x5f);
      }
      write_text(file, damaged);
      refused += can_be_read(folder.path()) ? 0 : 1;
    }
    write_text(file, whole);
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace limber
