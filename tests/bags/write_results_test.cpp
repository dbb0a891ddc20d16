// SPDX-License-Identifier: MIT
// Results as messages, against what ROS 1's and Foxglove's own writers make of the same numbers.
#include "limber/bags/write_results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>

#include "datasets/files.hpp"
#include "fixtures.hpp"
#include "limber/bags/read_bag.hpp"
#include "limber/core/errors.hpp"

namespace limber {
namespace {

using namespace limber::testing;

/// What results.json says.
RunResults example_results() {
  TrajectoryRow first;
  first.t_ns = kStart;
  first.T_world_body.R << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  first.T_world_body.p << 1, 2, 3;
  first.v_world_body = Eigen::Vector3d(1, 2, 3);
  first.bias_gyro = Eigen::Vector3d(0.001, 0.002, -0.003);
  first.bias_accel = Eigen::Vector3d(0.1, 0.2, 0.3);
  const Eigen::Matrix<double, 6, 1> n{1, 2, 3, 4, 5, 6};
  first.covariance = n * n.transpose() + 100.0 * Eigen::Matrix<double, 6, 6>::Identity();
  TrajectoryRow second;
  second.t_ns = kStart + kFrameInterval;
  second.T_world_body.R = Eigen::Vector3d(-1, -1, 1).asDiagonal();
  second.T_world_body.p << 1.5, 2.5, 3.5;
  const StampedPose truth{kStart + 10'000'000, {Eigen::Matrix3d::Identity(), {7, 8, 9}}};
  return {{first, second},
          {truth},
          {{17, {0.5, 1, 2}}, {23, {-4, 8, 16.25}}},
          {{second.t_ns,
            Diagnostic::Level::kError,
            "limber: calibration",
            "decalibrated: 3 px",
            {{"verdict", "decalibrated"}, {"epipolar [px]", "3"}}}}};
}

using Messages = std::map<std::string, std::vector<std::vector<std::uint8_t>>>;

/// By topic and type.
Messages messages_of(const fs::path& path) {
  Messages out;
  const auto bag = open_bag(path);
  bag->walk([](const BagTopic&) { return std::size_t{1} << 20; },
            [&](const BagMessage& message) {
              const BagTopic& topic = bag->topics()[message.topic];
              out[topic.name + " " + topic.type].emplace_back(message.data.begin(), message.data.end());
            });
  return out;
}

void expect_same_messages(const Messages& ours, const Messages& theirs) {
  EXPECT_EQ(ours.size(), 9u);
  EXPECT_EQ(ours.size(), theirs.size());
  for (const auto& [topic, messages] : theirs) {
    ASSERT_EQ(ours.count(topic), 1u) << topic;
    ASSERT_EQ(ours.at(topic).size(), messages.size()) << topic;
    for (std::size_t k = 0; k < messages.size(); ++k) {
      EXPECT_EQ(ours.at(topic)[k], messages[k]) << topic << " " << k;
    }
  }
}

/// Types and what the connections of a bag call the sum of their definitions.
std::map<std::string, std::string> sums_of(const fs::path& path) {
  const std::string bytes = read_text(path);
  std::map<std::string, std::string> out;
  const std::regex type("type=([A-Za-z0-9_]+/[A-Za-z0-9]+)"), sum("md5sum=([0-9a-f]{32})");
  std::vector<std::string> types, sums;
  for (std::sregex_iterator k(bytes.begin(), bytes.end(), type), end; k != end; ++k) {
    types.push_back((*k)[1]);
  }
  for (std::sregex_iterator k(bytes.begin(), bytes.end(), sum), end; k != end; ++k) {
    sums.push_back((*k)[1]);
  }
  EXPECT_EQ(types.size(), sums.size());
  for (std::size_t k = 0; k < std::min(types.size(), sums.size()); ++k) {
    out[types[k]] = sums[k];
  }
  return out;
}

TEST(WriteResults, MakesTheMessagesThatRos1MakesByteByByte) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "x.bag";
  write_results(example_results(), {file, BagFormat::kRos1, "none"});
  expect_same_messages(messages_of(file), messages_of(fixture("results.bag")));
  EXPECT_EQ(sums_of(file), sums_of(fixture("results.bag")));
  EXPECT_EQ(sums_of(file).size(), 7u);
}

TEST(WriteResults, MakesTheMessagesThatFoxgloveMakesByteByByte) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "x.mcap";
  write_results(example_results(), {file, BagFormat::kMcap, {}});
  expect_same_messages(messages_of(file), messages_of(fixture("results.mcap")));
}

TEST(WriteResults, ARecordingsTypesHaveTheSumsOfRos1) {
  const TemporaryFolder folder;
  StereoCalibration rig;
  rig.cam0.width = rig.cam1.width = kFixtureWidth;
  rig.cam0.height = rig.cam1.height = kFixtureHeight;
  rig.cam0.fu = rig.cam0.fv = rig.cam1.fu = rig.cam1.fv = 20.0;
  rig.theta(3) = -0.1;
  const auto topics = parse_bag_topics(
      "left=/cam0/image_raw,right=/cam1/image_raw/compressed,imu=/imu0,odometry=/odom,truth=/truth/pose");
  const fs::path file = folder.path() / "x.bag";
  write_bag(read_bag(fixture("ros1_none.bag"), rig, ImuNoise{}, topics), {file, BagFormat::kRos1, "none"});
  const auto ours = sums_of(file), theirs = sums_of(fixture("ros1_none.bag"));
  EXPECT_EQ(ours.size(), 5u);
  for (const auto& [type, sum] : ours) {
    if (type != "geometry_msgs/TwistStamped") {  // rosbag_test.py looks at it
      EXPECT_EQ(theirs.at(type), sum) << type;
    }
  }
}

TEST(WriteResults, LeavesNothingBehindOfWhatCannotBeStamped) {
  const TemporaryFolder folder;
  RunResults late = example_results();
  late.diagnostics.front().t_ns = late.trajectory.back().t_ns = std::int64_t{1} << 62;  // the year 2116
  const fs::path mcap = folder.path() / "x.mcap", bag = folder.path() / "x.bag";
  EXPECT_THROW(write_results(late, {mcap, BagFormat::kMcap, {}}), std::invalid_argument);
  EXPECT_THROW(write_results(late, {bag, BagFormat::kRos1, {}}), std::invalid_argument);
  EXPECT_THROW(write_results({}, {bag, BagFormat::kRos1, {}}), std::invalid_argument);
  EXPECT_TRUE(files_in(folder.path()).empty());
}

}  // namespace
}  // namespace limber
