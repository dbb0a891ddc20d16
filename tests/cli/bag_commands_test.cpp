// SPDX-License-Identifier: MIT
// limber info, limber convert, and bags in the place of folders.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "limber/datasets/track_log.hpp"
#include "run/short_recording.hpp"
#include "run_program.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::ProgramResult;
using testing::read_text;
using testing::run_limber;
using testing::source_folder;
using testing::TemporaryFolder;
using testing::write_text;

std::string bag(const std::string& name) {
  return (source_folder() / "tests" / "bags" / "fixtures" / name).string();
}

/// Kalibr's files for the cameras of the fixtures.
class BagCommands : public ::testing::Test {
 protected:
  [[nodiscard]] ProgramResult convert(const std::string& from, const std::string& to,
                                      std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"convert", from, "--out", to};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_limber(arguments);
  }
  [[nodiscard]] std::string path(const char* name) const { return (folder.path() / name).string(); }

  const TemporaryFolder folder;
  const std::string camchain = bag("camchain.yaml"), imu = bag("imu.yaml");
};

std::map<std::string, std::string> contents_below(const fs::path& folder) {
  std::map<std::string, std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      out[entry.path().lexically_relative(folder).string()] = read_text(entry.path());
    }
  }
  return out;
}

TEST_F(BagCommands, SayWhatToDoWhereABagIsNotTaken) {
  const auto bent = run_limber({"decalibrate", bag("lz4.mcap"), "--as", "ay=1", "--out", path("bent")});
  EXPECT_EQ(bent.exit_code, 1);
  EXPECT_THAT(bent.err, HasSubstr("found a bag: limber convert makes a folder of it"));
  const std::string old = write_text(folder.path() / "old.bag", "#ROSBAG V1.2\n").string();
  EXPECT_THAT(run_limber({"info", old}).err,
              HasSubstr("does not begin like a bag of its ending: ROS 1 (version 2.0)"));
}

TEST_F(BagCommands, InfoSaysWhatIsInABagAndWhatCanBeDone) {
  const ProgramResult text = run_limber({"info", bag("ros1_bz2.bag")});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("--topics left=/cam0/image_raw,right=/cam1/image_raw,imu=/imu0"));
  EXPECT_THAT(text.out, HasSubstr("limber health"));
  const auto json = nlohmann::json::parse(run_limber({"info", bag("ros2.db3"), "--json"}).out);
  EXPECT_EQ(json["format"], "ROS 2 bag (sqlite3)");
  EXPECT_EQ(json["streams"].size(), 9u);
  EXPECT_EQ(json["stereo"]["pairs"], 5);
  EXPECT_TRUE(json["stereo"]["synchronised"]);
  EXPECT_NEAR(json["stereo"]["mean_grey"][0].get<double>(), 142, 2);
}

TEST_F(BagCommands, RunAndConvertAskForTheCalibrationOfABag) {
  const ProgramResult run = run_limber({"run", bag("zstd.mcap"), "--out", path("run")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--calib"));
  EXPECT_EQ(convert(bag("zstd.mcap"), path("x")).exit_code, 2);
}

TEST_F(BagCommands, AFileInThePlaceOfAFolderIsToldWhatItIs) {
  const auto refused = [&](const char* name, const char* content) {
    write_text(folder.path() / name, content);
    const ProgramResult result = run_limber({"health", path(name)});
    EXPECT_EQ(result.exit_code, 1);
    return result.err;
  };
  EXPECT_THAT(refused("a.yaml", "cam0:\n"), HasSubstr("--calib"));
  EXPECT_THAT(refused("a.mp4", "x"), HasSubstr("a video"));
  EXPECT_THAT(refused("a.db3.zstd", "x"), HasSubstr("no bag packed by zstd"));
  EXPECT_THAT(refused("a.tum", "1 2"), HasSubstr("limber evaluate"));
  EXPECT_THAT(refused("a.xyz", "1 2"), HasSubstr("of a kind that limber does not know"));
}

TEST_F(BagCommands, ABagThroughFolderAndMcapIsTheSameFolderAgain) {
  const ProgramResult first = convert(bag("ros1_lz4.bag"), path("one"), {"--calib", camchain, "--imu", imu});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const auto files = contents_below(folder.path() / "one");
  EXPECT_EQ(files.size(), 2u * 5u + 2u + 2u + 2u + 1u) << "images, lists, cameras, IMU, truth";
  const ProgramResult second = convert(path("one"), path("x.mcap"));
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.err, HasSubstr("holds no calibration: keep it"));
  const ProgramResult third = convert(path("x.mcap"), path("two"), {"--calib", path("one"), "--imu", imu});
  ASSERT_EQ(third.exit_code, 0) << third.err;
  for (const auto& [name, content] : contents_below(folder.path() / "two")) {
    EXPECT_EQ(files.count(name), 1u) << name;
    if (name.find("groundtruth") == std::string::npos) {  // quaternions, up to rounding
      EXPECT_TRUE(files.count(name) == 1 && files.at(name) == content) << name;
    }
  }
}

TEST_F(BagCommands, AnMcapFileThroughABagIsTheSameMcapFileAgain) {
  const std::vector<std::string> with = {"--calib", camchain};
  ASSERT_EQ(convert(bag("zstd.mcap"), path("one.mcap"), with).exit_code, 0);
  ASSERT_EQ(convert(path("one.mcap"), path("x.bag"), with).exit_code, 0);
  ASSERT_EQ(convert(path("x.bag"), path("two.mcap"), with).exit_code, 0);
  EXPECT_EQ(read_text(path("one.mcap")), read_text(path("two.mcap")));
}

TEST_F(BagCommands, ConvertKnowsWhatEachFormatCanBeCompressedWith) {
  const auto refused = [&](const char* out, const char* compression) {
    const ProgramResult result =
        convert(bag("zstd.mcap"), path(out), {"--calib", camchain, "--compression", compression});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_FALSE(fs::exists(path(out)));
    return result.err;
  };
  EXPECT_THAT(refused("x.bag", "zstd"), HasSubstr("of a .bag file is lz4, bz2, none"));
  EXPECT_THAT(refused("x.mcap", "bz2"), HasSubstr("of a .mcap file is zstd, lz4, none"));
  EXPECT_THAT(refused("folder", "lz4"), HasSubstr("only FILE.mcap and FILE.bag have one"));
}

TEST_F(BagCommands, ConvertReplacesOnlyWithForceAndNeverItsInput) {
  const std::vector<std::string> with = {"--calib", camchain, "--imu", imu};
  ASSERT_EQ(convert(bag("lz4.mcap"), path("one"), with).exit_code, 0);
  const ProgramResult again = convert(bag("lz4.mcap"), path("one"), with);
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.err, HasSubstr("--force"));
  EXPECT_EQ(convert(bag("lz4.mcap"), path("one"), {"--calib", camchain, "--force"}).exit_code, 0);
  write_text(folder.path() / "mine.mcap", "mine");
  EXPECT_EQ(convert(path("one"), path("mine.mcap")).exit_code, 1);
  EXPECT_EQ(read_text(path("mine.mcap")), "mine");
  EXPECT_EQ(convert(path("one"), path("mine.mcap"), {"--force", "--pixels", "raw"}).exit_code, 0);
  const std::string list = (folder.path() / "one/mav0/imu0/data.csv").string(), samples = read_text(list);
  EXPECT_EQ(convert(path("one"), list, {"--force"}).exit_code, 1) << "a part of the input";
  EXPECT_EQ(read_text(list), samples);
  const auto before = read_text(path("mine.mcap"));
  const ProgramResult self = convert(path("mine.mcap"), path("mine.mcap"), {"--force", "--calib", camchain});
  EXPECT_EQ(self.exit_code, 1);
  EXPECT_EQ(read_text(path("mine.mcap")), before);
}

TEST_F(BagCommands, PosesOfABagBecomeATrajectoryFile) {
  ASSERT_EQ(convert(bag("ros2.db3"), path("t.tum")).exit_code, 0);
  EXPECT_THAT(read_text(path("t.tum")), HasSubstr("1600000000.223456789 1 0 0 0 0 0.6 0.8\n"));
  ASSERT_EQ(convert(bag("ros2.db3"), path("v.tum"), {"--topics", "truth=/vicon/body"}).exit_code, 0);
  EXPECT_THAT(read_text(path("v.tum")), HasSubstr("1600000000.223456789 0 0.5 0 0 0 0 1\n"));
  ASSERT_EQ(convert(path("t.tum"), path("t.kitti")).exit_code, 0);
  ASSERT_EQ(convert(path("t.kitti"), path("t2.kitti")).exit_code, 0);
  EXPECT_EQ(read_text(path("t.kitti")), read_text(path("t2.kitti")));
  const ProgramResult no_times = convert(path("t.kitti"), path("t.txt"));
  EXPECT_EQ(no_times.exit_code, 1);
  EXPECT_THAT(no_times.err, HasSubstr("has no times"));
}

TEST_F(BagCommands, PosesOfABagAreEvaluated) {
  ASSERT_EQ(convert(bag("ros2.db3"), path("t.tum")).exit_code, 0);
  const ProgramResult from_file = run_limber({"evaluate", path("t.tum"), path("t.tum"), "--json"});
  ASSERT_EQ(from_file.exit_code, 0) << from_file.err;
  for (const char* const name : {"ros1_lz4.bag", "zstd.mcap", "ros2.db3"}) {
    const ProgramResult truth = run_limber({"evaluate", path("t.tum"), bag(name), "--json"});
    EXPECT_EQ(truth.exit_code, 0) << truth.err;
    EXPECT_THAT(truth.err, HasSubstr("poses of /truth/pose"));
    EXPECT_EQ(nlohmann::json::parse(truth.out)["ate_m"], nlohmann::json::parse(from_file.out)["ate_m"]);
  }
  const auto both = [](const std::vector<std::string>& topics) {
    std::vector<std::string> arguments = {"evaluate", bag("ros1_none.bag"), bag("ros1_none.bag")};
    arguments.insert(arguments.end(), topics.begin(), topics.end());
    return run_limber(arguments);
  };
  EXPECT_THAT(both({"--estimate-topic", "/odom", "--truth-topic", "/vicon/body"}).err,
              AllOf(HasSubstr("poses of /odom\n"), HasSubstr("poses of /vicon/body\n")));
  const ProgramResult unnamed = both({});
  EXPECT_EQ(unnamed.exit_code, 1);
  EXPECT_THAT(unnamed.err, HasSubstr("expected one topic of poses, or the name of it, found poses "
                                     "(PoseStamped, TransformStamped, Odometry) on /truth/pose, /vicon/body, "
                                     "/odom"));
  EXPECT_THAT(both({"--estimate-topic", "/odon"}).err, HasSubstr("poses on /odon (did you mean /odom?)"));
  const ProgramResult points = run_limber({"evaluate", path("t.tum"), bag("ros1_points.bag")});
  EXPECT_EQ(points.exit_code, 1);
  EXPECT_THAT(points.err, HasSubstr("on none; /leica/position has positions alone, without attitude"));
}

TEST_F(BagCommands, ATrajectoryBecomesMessagesAndATrajectoryAgain) {
  ASSERT_EQ(convert(bag("ros2.db3"), path("t.tum")).exit_code, 0);
  for (const char* name : {"t.bag", "t.mcap"}) {
    ASSERT_EQ(convert(path("t.tum"), path(name)).exit_code, 0);
    const ProgramResult back =
        convert(path(name), path("back.tum"), {"--topics", "truth=/limber/odometry", "--force"});
    ASSERT_EQ(back.exit_code, 0) << back.err;
    EXPECT_EQ(read_text(path("back.tum")), read_text(path("t.tum")));
  }
  ASSERT_EQ(convert(path("t.tum"), path("t.kitti")).exit_code, 0);
  const ProgramResult no_times = convert(path("t.kitti"), path("k.bag"));
  EXPECT_EQ(no_times.exit_code, 1);
  EXPECT_THAT(no_times.err, HasSubstr("has no times"));
  EXPECT_FALSE(fs::exists(path("k.bag")));
}

TEST_F(BagCommands, ARunBecomesMessagesThatFoxgloveAndRvizShow) {
  write_track_log(testing::short_recording(), folder.path() / "log");
  const ProgramResult run = run_limber({"run", path("log"), "--init", "groundtruth", "--out", path("run")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ProgramResult out = convert(path("run"), path("run.mcap"));
  ASSERT_EQ(out.exit_code, 0) << out.err;
  const auto json = nlohmann::json::parse(run_limber({"info", path("run.mcap"), "--json"}).out);
  std::map<std::string, int> messages;
  for (const auto& stream : json["streams"]) {
    messages[stream["name"]] = stream["messages"];
  }
  EXPECT_EQ(messages["/tf"], 41);
  EXPECT_EQ(messages["/limber/odometry"], 41);
  EXPECT_EQ(messages["/groundtruth"], 41);
  EXPECT_EQ(messages["/limber/path"] + messages["/groundtruth/path"] + messages["/limber/map"], 3);
  EXPECT_GE(messages["/diagnostics"], 41);
  const std::string before = read_text(path("run.mcap"));
  fs::remove(folder.path() / "run/landmarks.ply");
  const ProgramResult missing = convert(path("run"), path("run.mcap"), {"--force"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.err, HasSubstr("landmarks.ply"));
  EXPECT_EQ(read_text(path("run.mcap")), before);
}

TEST_F(BagCommands, APointlessOptionIsRefused) {
  const auto refused = [&](const std::vector<std::string>& arguments, int code) {
    const ProgramResult result = run_limber(arguments);
    EXPECT_EQ(result.exit_code, code) << result.err;
    return result.err;
  };
  const std::string mcap = bag("zstd.mcap"), out = path("out");
  EXPECT_THAT(refused({"run", mcap, "--calib", camchain, "--images", "rectified", "--out", out}, 1),
              HasSubstr("camchain.yaml: the calibration is of raw images (with distortion), said were "
                        "rectified ones"));
  const std::string without_imu =
      std::regex_replace(read_text(camchain), std::regex("  T_cam_imu:\n(  - .*\n){4}"), "");
  const std::string cameras = write_text(folder.path() / "cameras.yaml", without_imu).string();
  EXPECT_THAT(refused({"run", mcap, "--calib", cameras, "--imu", imu, "--out", out}, 2),
              HasSubstr("does not place the cameras on an IMU (T_cam_imu)"));
  EXPECT_THAT(
      refused({"run", mcap, "--calib", camchain, "--imu", imu, "--topics", "odometry=/odom", "--out", out},
              2),
      HasSubstr("no IMU is taken from it, limber info " + mcap + " lists its topics"));
  EXPECT_THAT(refused({"run", mcap, "--calib", camchain, "--topics", "lft=/cam0/image_raw", "--out", out}, 2),
              HasSubstr("did you mean left?"));
  EXPECT_THAT(refused({"health", mcap, "--calib", camchain, "--tolerance", "dpth=5"}, 2),
              HasSubstr("did you mean depth?"));
  EXPECT_THAT(refused({"convert", mcap, "--calib", camchain, "--out", path("t.tum")}, 2),
              HasSubstr("only a recording has it"));
}

TEST_F(BagCommands, ConvertNamesTheEndingsThatItKnows) {
  for (const char* name : {"x.pdf", "x.mcp", "x.json"}) {
    const ProgramResult result = convert(bag("zstd.mcap"), path(name), {"--calib", camchain});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr("FILE.mcap or FILE.bag (messages), FILE.tum"));
    EXPECT_FALSE(fs::exists(path(name)));
  }
  EXPECT_THAT(convert(bag("zstd.mcap"), path("x.mcp"), {"--calib", camchain}).err,
              HasSubstr("did you mean .mcap?"));
  EXPECT_EQ(convert(bag("zstd.mcap"), path("flight.1"), {"--calib", camchain}).exit_code, 0);
  EXPECT_EQ(convert(bag("zstd.mcap"), path("flight.raw/"), {"--calib", camchain}).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder.path() / "flight.raw/mav0/cam0/data.csv"));
}

TEST_F(BagCommands, ARunThatBecameMessagesGivesItsTrajectoryAgain) {
  write_track_log(testing::short_recording(), folder.path() / "log");
  ASSERT_EQ(run_limber({"run", path("log"), "--init", "groundtruth", "--out", path("run")}).exit_code, 0);
  ASSERT_EQ(convert(path("run"), path("run.mcap")).exit_code, 0);
  const ProgramResult back = convert(path("run.mcap"), path("back.tum"));
  ASSERT_EQ(back.exit_code, 0) << back.err;
  EXPECT_THAT(back.err, HasSubstr("poses of /limber/odometry; --topics truth=TOPIC takes others"));
  EXPECT_EQ(read_text(path("back.tum")).substr(0, 40), read_text(path("run/trajectory.tum")).substr(0, 40));
  const ProgramResult judged = run_limber({"evaluate", path("run.mcap"), path("run.mcap"), "--json"});
  EXPECT_EQ(judged.exit_code, 0) << "its own poses against the truth in it: " << judged.err;
  const ProgramResult no_bag =
      run_limber({"evaluate", path("run"), path("run.mcap"), "--estimate-topic", "/x"});
  EXPECT_EQ(no_bag.exit_code, 1);
  EXPECT_THAT(no_bag.err, HasSubstr("expected a bag, for the topic /x"));
  for (const char* const option : {"--max-tracks", "--threads"}) {
    const std::string value = option == std::string("--threads") ? "1" : "50";
    const ProgramResult no_images = run_limber({"run", path("log"), option, value, "--out", path("other")});
    EXPECT_EQ(no_images.exit_code, 2);
    EXPECT_THAT(no_images.err, HasSubstr(option));
    EXPECT_THAT(no_images.err, HasSubstr("holds matched points, no images"));
  }
  ASSERT_EQ(convert(path("run.mcap"), path("truth.tum"), {"--topics", "truth=/groundtruth"}).exit_code, 0);
  EXPECT_NE(read_text(path("truth.tum")), read_text(path("back.tum")));
  const ProgramResult no_recording = convert(path("run"), path("folder"));
  EXPECT_EQ(no_recording.exit_code, 2);
  EXPECT_THAT(no_recording.err, HasSubstr("a run becomes FILE.mcap"));
}

TEST_F(BagCommands, OfADamagedBagWhatIsReadableIsWrittenAndTheExitCodeIsOne) {
  std::string content = read_text(bag("ros1_lz4.bag"));
  content.replace(content.find("compression=", 4200) + 200, 40, 40, '\xee');
  write_text(folder.path() / "holed.bag", content);
  const ProgramResult result = convert(path("holed.bag"), path("x"), {"--calib", camchain});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, AllOf(HasSubstr("a damaged chunk"), HasSubstr("bytes are left out"),
                                HasSubstr("written without the parts that are missing")));
  EXPECT_TRUE(fs::exists(folder.path() / "x/mav0/cam0/data.csv"));
}

}  // namespace
}  // namespace limber
