// SPDX-License-Identifier: MIT
// `limber run` on images: an EuRoC folder of a painted room that a small rig flies through.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/run_program.hpp"
#include "frontend/painted_room.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/images/picture.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::read_text;
using testing::write_text;

constexpr std::int64_t kFrames = 6, kPeriodNs = 50'000'000;

void write_png(const fs::path& file, int width, int height, const std::vector<std::uint8_t>& pixels) {
  const auto bytes = encode_png({width, height, 1, 8, static_cast<std::size_t>(width), pixels.data()});
  write_text(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string line_of(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
}

class ImageFolder : public ::testing::Test {
 protected:
  ImageFolder() {
    Recording recording;
    recording.calibration = testing::small_rig();
    recording.frames.push_back({0, {}});
    for (std::int64_t k = 0; k < kFrames; ++k) {
      const Pose T_world_cam0 = testing::flight(static_cast<int>(k));
      recording.truth.motion.states.push_back({k * kPeriodNs, T_world_cam0.R, T_world_cam0.p, {}, {}, {}});
    }
    write_track_log(recording, root_.path());
    fs::remove_all(mav0() / "tracks0");
    const Pose T_cam0_cam1 = pose_from_rig(recording.calibration.theta).inverse();
    write_images("cam0", recording.calibration.cam0, Pose{});
    write_images("cam1", recording.calibration.cam1, T_cam0_cam1);
  }

  [[nodiscard]] fs::path mav0() const { return root_.path() / "mav0"; }
  [[nodiscard]] fs::path out() const { return root_.path() / "out"; }
  [[nodiscard]] fs::path image(const char* camera, std::int64_t k) const {
    return mav0() / camera / "data" / (std::to_string(k * kPeriodNs) + ".png");
  }
  [[nodiscard]] testing::ProgramResult run() const {
    return testing::run_limber({"run", root_.path().string(), "--out", out().string()});
  }
  void expect_refused(const fs::path& place, const std::string& words) const {
    const auto result = run();
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, ::testing::StartsWith("limber: error: " + place.string()));
    EXPECT_THAT(result.err, HasSubstr(words));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(fs::exists(out()));
  }

 private:
  void write_images(const char* name, const Camera& camera, const Pose& T_cam0_cam) const {
    std::string list = "#timestamp [ns],filename\n";
    fs::create_directories(mav0() / name / "data");
    for (std::int64_t k = 0; k < kFrames; ++k) {
      const testing::Image picture =
          testing::photograph(camera, testing::flight(static_cast<int>(k)) * T_cam0_cam,
                              {1.0, 0.0, 1.0, static_cast<std::uint64_t>(k)});
      write_png(image(name, k), picture.width, picture.height, picture.pixels);
      list += std::to_string(k * kPeriodNs) + "," + image(name, k).filename().string() + "\n";
    }
    write_text(mav0() / name / "data.csv", list);
  }

  testing::TemporaryFolder root_;
};

TEST_F(ImageFolder, IsNavigated) {
  const auto result = run();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("pixel noise not given: learned, from 0.5 px on"));
  const auto summary = nlohmann::json::parse(read_text(out() / "summary.json"));
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_EQ(summary["frames_unreadable"], 0);
  EXPECT_GT(summary["points_per_frame"], 60.0);
  EXPECT_LT(summary["ate_m"]["se3"], 0.05);
}

TEST_F(ImageFolder, IsNavigatedAlikeOnOneThreadAndOnTwoAndSaysWhatTheImagesTook) {
  const fs::path alone = mav0().parent_path() / "alone", beside = mav0().parent_path() / "beside",
                 each = mav0().parent_path() / "each";
  const std::string data = mav0().parent_path().string();
  ASSERT_EQ(testing::run_limber({"run", data, "--threads", "1", "--out", alone.string()}).exit_code, 0);
  ASSERT_EQ(testing::run_limber({"run", data, "--threads", "2", "--out", beside.string()}).exit_code, 0);
  ASSERT_EQ(testing::run_limber({"run", data, "--threads", "3", "--out", each.string()}).exit_code, 0);
  EXPECT_EQ(testing::read_text(alone / "trajectory.csv"), testing::read_text(beside / "trajectory.csv"));
  EXPECT_EQ(testing::read_text(alone / "trajectory.csv"), testing::read_text(each / "trajectory.csv"));
  const auto summary = nlohmann::json::parse(testing::read_text(beside / "summary.json"));
  for (const char* const part : {"decode", "track", "end_to_end"}) {
    EXPECT_GT(summary["ms_per_frame"][part]["p50"].get<double>(), 0.0) << part;
    EXPECT_GE(summary["ms_per_frame"][part]["worst"], summary["ms_per_frame"][part]["p99"]) << part;
  }
  EXPECT_GE(summary["frontend"]["left_points"], summary["frontend"]["right_points"]);
  EXPECT_GE(summary["frontend"]["frames_per_track"], 1.0);

  const fs::path few = mav0().parent_path() / "few";
  ASSERT_EQ(testing::run_limber({"run", data, "--max-tracks", "20", "--out", few.string()}).exit_code, 0);
  EXPECT_LE(nlohmann::json::parse(testing::read_text(few / "summary.json"))["frontend"]["left_points"], 20.0);
}

TEST_F(ImageFolder, IsReadOnceForSeveralMethodsWhichFindWhatEachFindsAlone) {
  const std::string data = mav0().parent_path().string();
  const auto result = testing::run_limber({"run", data, "--methods", "ekf,lcekf", "--out", out().string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  nlohmann::json times;
  for (const char* const method : {"ekf", "lcekf"}) {
    const fs::path alone = mav0().parent_path() / method;
    ASSERT_EQ(testing::run_limber({"run", data, "--method", method, "--out", alone.string()}).exit_code, 0);
    for (const char* const file : {"trajectory.csv", "landmarks.ply", "health.csv", "refusals.csv"}) {
      EXPECT_EQ(read_text(out() / method / file), read_text(alone / file)) << method << ", " << file;
    }
    times[method] = nlohmann::json::parse(read_text(out() / method / "summary.json"))["ms_per_frame"];
  }
  for (const char* const part : {"decode", "track"}) {  // to the nanosecond: measured once
    EXPECT_EQ(times["lcekf"][part], times["ekf"][part]) << part;
  }
}

TEST_F(ImageFolder, IsRefusedWhereMostImagesAreMissing) {
  for (const std::int64_t k : {2, 3, 4, 5}) {
    fs::remove(image("cam1", k));
  }
  expect_refused(mav0() / "cam1/data.csv:4", "expected the image 100000000.png");
}

/// `limber run` with these arguments goes on behind a damaged image, and says so.
void expect_one_lost_frame(const std::vector<std::string>& arguments, const fs::path& out,
                           const std::string& what) {
  const auto result = testing::run_limber(arguments);
  EXPECT_EQ(result.exit_code, 1) << "as of other damage";
  EXPECT_THAT(result.err, HasSubstr("the images of 1 of 6 frames cannot be read"));
  EXPECT_THAT(result.err, HasSubstr(what));
  const auto summary = nlohmann::json::parse(read_text(out / "summary.json"));
  EXPECT_EQ(summary["frames"], kFrames);
  EXPECT_EQ(summary["frames_unreadable"], 1);
  EXPECT_FALSE(summary["complete"]);
  EXPECT_LT(summary["ate_m"]["se3"], 0.05);
}

TEST_F(ImageFolder, GoesOnWhereAnImageIsTornOrNoneOrOfAnotherSize) {
  const std::string whole = read_text(image("cam0", 4));
  // Small as a file, 900 million pixels unpacked: refused by its header.
  const std::string huge = testing::png_header(30'000, 30'000) + std::string(1000, '\0') + "IEND1234";
  const std::pair<std::string, const char*> damaged[] = {
      {whole.substr(0, whole.size() / 2), "found a PNG file that was cut off"},
      {"this is no image", "found nothing that can be decoded as an image"},
      {huge, "found 30000 x 30000 px"}};
  for (const auto& [content, words] : damaged) {
    write_text(image("cam0", 4), content);
    for (const char* const threads : {"1", "2", "3"}) {
      expect_one_lost_frame(
          {"run", mav0().parent_path().string(), "--threads", threads, "--out", out().string(), "--force"},
          out(), "at 200000000 ns: " + image("cam0", 4).string() + ": ");
      EXPECT_THAT(read_text(out() / "summary.json"), HasSubstr(words));
    }
  }
}

TEST_F(ImageFolder, GoesOnWhereAnImageIsMissingOrAFolderOrAPipe) {
  const std::string data = mav0().parent_path().string();
  const auto expect_one_lost = [&] {
    expect_one_lost_frame(
        {"run", data, "--out", out().string(), "--force"}, out(),
        image("cam0", 0).string() + ": expected an image of 376 x 240 px, found no readable file");
    EXPECT_THAT(testing::run_limber({"info", data}).out,
                HasSubstr("1 of 6 pairs cannot be used, their frames will have no points; the first: " +
                          image("cam0", 0).string()));
    const fs::path bag = mav0().parent_path() / "x.mcap";
    fs::remove(bag);
    const auto converted = testing::run_limber({"convert", data, "--out", bag.string()});
    EXPECT_EQ(converted.exit_code, 1);
    EXPECT_THAT(converted.err,
                HasSubstr("the image of cam0 at 0 ns is left out: " + image("cam0", 0).string()));
  };
  fs::remove(image("cam0", 0));
  expect_one_lost();
  fs::create_directory(image("cam0", 0));
  expect_one_lost();
  fs::remove(image("cam0", 0));
  ASSERT_EQ(::mkfifo(image("cam0", 0).c_str(), 0600), 0);  // to open it would be to wait
  expect_one_lost();
}

// Cameras of 12 bits whose driver writes them as they are: dark to a viewer, and to a reader of the high
// byte.
TEST_F(ImageFolder, OfTwelveBitsIsTheSameToTheBitAsFilesAsABagOfFilesAndAsABagOfPixels) {
  for (std::int64_t k = 0; k < kFrames; ++k) {
    for (const char* const camera : {"cam0", "cam1"}) {
      const Picture eight = decode_picture(read_text(image(camera, k)), Colours::kToGrey, "a picture");
      std::vector<std::uint16_t> twelve;
      for (const std::uint8_t value : eight.data)
        twelve.push_back(static_cast<std::uint16_t>(16 * value + 7));
      const auto png = encode_png({eight.width, eight.height, 1, 16, 2 * eight.stride(),
                                   reinterpret_cast<const std::uint8_t*>(twelve.data())});
      write_text(image(camera, k), {reinterpret_cast<const char*>(png.data()), png.size()});
    }
  }
  const std::string data = mav0().parent_path().string();
  ASSERT_EQ(run().exit_code, 0);
  const std::string trajectory = read_text(out() / "trajectory.csv");
  for (const char* const pixels : {"keep", "raw"}) {
    const fs::path bag = mav0().parent_path() / (std::string(pixels) + ".mcap");
    ASSERT_EQ(testing::run_limber({"convert", data, "--out", bag.string(), "--pixels", pixels}).exit_code, 0);
    const auto result = testing::run_limber(
        {"run", bag.string(), "--calib", data, "--out", out().string(), "--init", "auto", "--force"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(read_text(out() / "trajectory.csv"), trajectory) << pixels;
    const auto info = testing::run_limber({"info", bag.string()}),
               of_files = testing::run_limber({"info", data});
    EXPECT_EQ(line_of(info.out, "mean grey"), line_of(of_files.out, "mean grey")) << pixels;
  }
}

TEST_F(ImageFolder, GoesOnWhereTheFirstImageIsDamagedBehindItsHeader) {
  const std::string whole = read_text(image("cam1", 0));
  write_text(image("cam1", 0), whole.substr(0, whole.size() / 2));
  expect_one_lost_frame({"run", mav0().parent_path().string(), "--out", out().string()}, out(),
                        "at 0 ns: " + image("cam1", 0).string());
}

TEST_F(ImageFolder, IsRefusedWhereNoImageCanBeUsed) {
  for (std::int64_t k = 0; k < kFrames; ++k) {
    const std::string whole = read_text(image("cam1", k));
    write_text(image("cam1", k), whole.substr(0, whole.size() / 2));
  }
  expect_refused(image("cam1", kFrames - 1), "found a PNG file that was cut off");
}

TEST_F(ImageFolder, AsABagGoesOnWhereAPictureInItIsDamaged) {
  const std::string data = mav0().parent_path().string();
  const fs::path bag = mav0().parent_path() / "x.mcap";
  ASSERT_EQ(testing::run_limber({"convert", data, "--out", bag.string(), "--compression", "none"}).exit_code,
            0);
  std::string content = read_text(bag);
  const std::string picture = read_text(image("cam1", 3));
  const std::size_t at = content.find(picture);
  ASSERT_NE(at, std::string::npos) << "as it lay in the folder";
  content.replace(at + picture.size() / 2, 64, std::string(64, '\xee'));
  write_text(bag, content);
  expect_one_lost_frame({"run", bag.string(), "--calib", data, "--out", out().string()}, out(),
                        "at 150000000 ns: " + bag.string() + ", topic ");
}

TEST_F(ImageFolder, AsABagGoesOnWhereAnImageIsOfAnotherSize) {
  const std::string data = mav0().parent_path().string();
  const fs::path bag = mav0().parent_path() / "x.mcap";
  const std::string whole = read_text(image("cam1", 0));
  for (const std::int64_t k : {0, 3}) {
    write_png(image("cam1", k), 40, 30, std::vector<std::uint8_t>(40 * 30, 90));
    for (const char* const pixels : {"keep", "raw"}) {
      fs::remove(bag);  // in the folder that is read: never replaced
      ASSERT_EQ(testing::run_limber({"convert", data, "--out", bag.string(), "--pixels", pixels}).exit_code,
                0);
      expect_one_lost_frame({"run", bag.string(), "--calib", data, "--out", out().string(), "--force"}, out(),
                            "(the calibration's resolution), found 40 x 30 px");
      if (pixels == std::string("raw")) {
        EXPECT_THAT(testing::run_limber({"info", bag.string()}).out,
                    HasSubstr("1 of 6 images differ from the others in size or encoding"));
      }
    }
    write_text(image("cam1", 0), whole);
  }
}

TEST_F(ImageFolder, IsInspectedWhereImagesAreTorn) {
  const std::string data = mav0().parent_path().string();
  const std::string whole = read_text(image("cam0", 0));
  write_text(image("cam0", 0), whole.substr(0, whole.size() / 2));
  const auto one = testing::run_limber({"info", data});
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_THAT(one.out, HasSubstr("of 6 pairs that were looked at 1 cannot be read; the first: " +
                                 image("cam0", 0).string()));
  EXPECT_THAT(one.out, HasSubstr("mean grey"));
  for (std::int64_t k = 1; k < kFrames; ++k) {
    fs::copy_file(image("cam0", 0), image("cam0", k), fs::copy_options::overwrite_existing);
  }
  const auto none = testing::run_limber({"info", data});
  EXPECT_EQ(none.exit_code, 0);
  EXPECT_THAT(none.out, HasSubstr("of 6 pairs that were looked at 6 cannot be read"));
  EXPECT_THAT(none.out, ::testing::Not(HasSubstr("mean grey")));
}

TEST_F(ImageFolder, IsConvertedWithoutTheImagesThatCannotBeRead) {
  const std::string data = mav0().parent_path().string();
  const std::string whole = read_text(image("cam1", 3));
  const std::pair<std::string, std::string> damaged[] = {
      {whole.substr(0, whole.size() / 2), "found a PNG file that was cut off"}, {"", "found an empty file"}};
  for (const auto& [content, words] : damaged) {
    write_text(image("cam1", 3), content);
    const fs::path bag = mav0().parent_path() / "x.mcap";
    fs::remove(bag);  // in the folder that is read: never replaced
    const auto result = testing::run_limber({"convert", data, "--out", bag.string(), "--pixels", "raw"});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, HasSubstr("the image of cam1 at 150000000 ns is left out: " +
                                      image("cam1", 3).string() + ": expected"));
    EXPECT_THAT(result.err, HasSubstr(words));
    EXPECT_EQ(result.out, bag.string() + "\n");
    const auto streams =
        nlohmann::json::parse(testing::run_limber({"info", bag.string(), "--json"}).out)["streams"];
    for (const auto& stream : streams) {
      if (stream["role"] == "left") EXPECT_EQ(stream["messages"], kFrames);
      if (stream["role"] == "right") EXPECT_EQ(stream["messages"], kFrames - 1);
    }
  }
}

}  // namespace
}  // namespace limber
