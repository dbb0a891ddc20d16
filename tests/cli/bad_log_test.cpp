// SPDX-License-Identifier: MIT
// Recordings that are broken, as a user meets them: exit code 1, one message with file and line, no output.
#include <sstream>

#include "cli/small_log.hpp"
#include "datasets/edits.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::append;
using testing::cut_end;
using testing::edit_file;
using testing::expect_refused;
using testing::header_only;
using testing::replace;
using testing::replace_between;
using testing::write_text;

struct BadLog {
  const char* name;
  const char* place;  ///< within mav0, with the line where there is one
  const char* words;
  std::function<void(const fs::path& mav0)> spoil;
};

void PrintTo(const BadLog& bad, std::ostream* stream) { *stream << bad.name; }

/// Spoils one file.
std::function<void(const fs::path&)> in(const char* file, const testing::Edit& edit) {
  return [=](const fs::path& mav0) { edit_file(mav0 / file, edit); };
}

testing::Edit whole(const std::string& text) {
  return [=](const std::string&) { return text; };
}

/// Another line, or lines, in place of the first of the tracks.
testing::Edit first_point(const std::string& line) { return replace_between("v1 [px]\n", "\n", line); }

/// Without the last digits of each time: a coarser unit.
testing::Edit shortened_times(std::size_t digits) {
  return [=](const std::string& text) {
    std::string out;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line); out += line + "\n") {
      const std::size_t comma = line.find(',');
      if (line[0] != '#' && comma > digits) {
        line.erase(comma - digits, digits);
      }
    }
    return out;
  };
}

constexpr const char* kTracks = "tracks0/data.csv";
constexpr const char* kImu = "imu0/data.csv";
constexpr const char* kCam0 = "cam0/sensor.yaml";
constexpr const char* kCam1 = "cam1/sensor.yaml";
constexpr const char* kTruth = "state_groundtruth_estimate0/data.csv";

std::vector<BadLog> bad_logs() {
  return {
      {"MissingTracks", "/tracks0/data.csv: ", "expected a text file, found no such file",
       [](const fs::path& mav0) { fs::remove(mav0 / kTracks); }},
      {"MissingCamera", "/cam1/sensor.yaml: ", "found no such file",
       [](const fs::path& mav0) { fs::remove_all(mav0 / "cam1"); }},
      {"FolderForAFile", "/imu0/data.csv: ", "found something that is not a file",
       [](const fs::path& mav0) {
         fs::remove(mav0 / kImu);
         fs::create_directory(mav0 / kImu);
       }},
      {"TruncatedTable", "/imu0/data.csv:202: ", "and the file ends within this line", in(kImu, cut_end(70))},
      {"NanPixel", "/tracks0/data.csv:2: ", "expected a finite number for u0 [px], found 'nan'",
       in(kTracks, first_point("0,1,nan,2,3,4"))},
      {"InfinitePixel", "/tracks0/data.csv:2: ", "found 'inf'", in(kTracks, first_point("0,1,inf,2,3,4"))},
      {"PixelOfNoImage", "/tracks0/data.csv:2: ", "expected u0 [px] within ±4800, found '1e308'",
       in(kTracks, first_point("0,1,1e308,2,3,4"))},
      {"NanRate", "/imu0/data.csv:3: ", "expected a finite number for w_x, found 'NaN'",
       in(kImu, replace_between("\n10000000,", ",", "NaN"))},
      {"RateOfNoGyro", "/imu0/data.csv:3: ", "expected w_x within ±10000, found '1e300'",
       in(kImu, replace_between("\n10000000,", ",", "1e300"))},
      {"FramesOutOfOrder", "/tracks0/data.csv:", "expected a timestamp later than the previous one",
       in(kTracks, append("50000000,1,1,1,1,1\n"))},
      {"ImuOutOfOrder", "/imu0/data.csv:4: ",
       "expected a timestamp later than the previous one (10000000 ns), found 9000000 ns",
       in(kImu, replace("\n20000000,", "\n9000000,"))},
      {"ImuTwice", "/imu0/data.csv:4: ", "found the same timestamp again",
       in(kImu, replace("\n20000000,", "\n10000000,"))},
      {"ImuInMicroseconds", "/imu0/data.csv: ",
       "expected timestamps in nanoseconds, found steps of 10000: are these microseconds?",
       in(kImu, shortened_times(3))},
      {"FramesInMicroseconds", "/tracks0/data.csv: ", "found steps of 50000: are these microseconds?",
       in(kTracks, shortened_times(3))},
      {"FramesInMilliseconds", "/tracks0/data.csv: ", "found steps of 50: are these milliseconds?",
       in(kTracks, shortened_times(6))},
      {"TruthTwice", "/state_groundtruth_estimate0/data.csv:4: ", "found the same timestamp again",
       in(kTruth, replace("\n20000000,", "\n10000000,"))},
      {"PointTwice", "/tracks0/data.csv:3: ", "expected every track_id once in a frame, found 1 again",
       in(kTracks, first_point("0,1,1,1,1,1\n0,1,2,2,2,2"))},
      {"UnknownCameraModel", "/cam0/sensor.yaml:7: ", "expected camera_model pinhole or omni, found 'fov'",
       in(kCam0, replace("pinhole", "fov"))},
      {"UnknownDistortion", "/cam0/sensor.yaml:9: ", "expected distortion_model none, radial-tangential",
       in(kCam0, replace("distortion_model: none", "distortion_model: fov"))},
      {"NoRotation", "/cam1/sensor.yaml:3: ", "expected T_BS with a rotation in its upper left 3x3 block",
       in(kCam1, replace("data: [1, ", "data: [1.1, "))},
      {"NegativeBaseline",
       "/cam1/sensor.yaml:3: ", "found 2.000 m, cam1 to the left: are the cameras swapped",
       in(kCam1, replace("data: [1, 0, 0, 2", "data: [1, 0, 0, -2"))},
      {"ZeroBaseline",
       "/cam1/sensor.yaml:3: ", "expected two cameras that stand apart, found a baseline of zero",
       in(kCam1, replace("data: [1, 0, 0, 2", "data: [1, 0, 0, 0"))},
      {"EndlessBaseline", "/cam1/sensor.yaml:3: ", "expected cameras less than 1000 m apart",
       in(kCam1, replace("data: [1, 0, 0, 2", "data: [1, 0, 0, 2e200"))},
      {"EmptyTracks", "/tracks0/data.csv: ", "expected at least one frame, found none: the file has no data",
       in(kTracks, whole(""))},
      {"HeaderOnly", "/tracks0/data.csv: ", "expected at least one frame, found none",
       in(kTracks, header_only())},
      {"ImuOfNoSample", "/imu0/data.csv: ", "expected at least one IMU sample, found none",
       in(kImu, header_only())},
      {"BinaryTable", "/imu0/data.csv:1: ", "expected text, found binary data",
       in(kImu, whole(std::string("\x7f"
                                  "ELF\x02\x01\x00\x00",
                                  8)))},
      {"CompressedTable", "/tracks0/data.csv:1: ", "expected text, found binary data (byte 0x1f)",
       in(kTracks, whole("\x1f\x8b\x08"))},
      {"BinaryYaml", "/cam0/sensor.yaml:1: ", "expected text, found binary data",
       in(kCam0, whole(std::string("\x00\x01\x02", 3)))},
      {"NegativeNoise", "/imu0/sensor.yaml:6: ", "gyroscope_noise_density of zero or more",
       in("imu0/sensor.yaml", replace("noise_density: ", "noise_density: -"))},
      {"TruthOfNoKnownShape", "/state_groundtruth_estimate0/data.csv:2: ", "expected 8, 11 or 17 columns",
       in(kTruth, replace("\n0,", "\n0,0,"))},
  };
}

class BadLogs : public testing::SmallLog, public ::testing::WithParamInterface<BadLog> {};

TEST_P(BadLogs, AreRefusedWithFileLineAndWhatWasExpected) {
  const BadLog& bad = GetParam();
  bad.spoil(mav0());
  const auto result = run();
  expect_refused(result, 1, mav0().string() + bad.place);
  EXPECT_THAT(result.err, ::testing::HasSubstr(bad.words));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_FALSE(fs::exists(out()));
}

INSTANTIATE_TEST_SUITE_P(EachFile, BadLogs, ::testing::ValuesIn(bad_logs()),
                         [](const auto& test) { return std::string(test.param.name); });

using NoLog = testing::SmallLog;

TEST_F(NoLog, IsRefusedWithWhatWouldBeOne) {
  const auto run_on = [this](const fs::path& dataset) {
    return testing::run_limber({"run", dataset.string(), "--out", out().string()});
  };
  expect_refused(run_on(folder() / "nowhere"), 1,
                 "expected the folder of a recording, or a bag, found no such file or folder");
  expect_refused(run_on(write_text(folder() / "file", "x")), 1,
                 "expected the folder of a recording, or a bag, found a file");
  fs::create_directory(folder() / "empty");
  expect_refused(run_on(folder() / "empty"), 1, "mav0/tracks0 (track log)");
  expect_refused(run_on(""), 2, "DATASET: expected a name, found nothing");
  EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace limber
