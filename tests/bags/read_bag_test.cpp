// SPDX-License-Identifier: MIT
#include "limber/bags/read_bag.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/files.hpp"
#include "fixtures.hpp"
#include "limber/bags/inspect.hpp"
#include "limber/bags/write_bag.hpp"
#include "limber/core/errors.hpp"
#include "message_of.hpp"

namespace limber {
namespace {

using namespace limber::testing;
using ::testing::Contains;
using ::testing::HasSubstr;

StereoCalibration fixture_rig() {
  StereoCalibration out;
  out.cam0.width = out.cam1.width = kFixtureWidth;
  out.cam0.height = out.cam1.height = kFixtureHeight;
  out.theta(3) = -0.1;
  return out;
}

class ReadBag : public ::testing::TestWithParam<std::string> {};

TEST_P(ReadBag, GivesARecordingWhoseImagesStayInTheBag) {
  const Recording recording = read_bag(fixture(GetParam()), fixture_rig(), ImuNoise{});
  EXPECT_EQ(recording.imu.size(), kFixtureImu);
  EXPECT_EQ(recording.imu[7].t_ns, kStart + 7 * kImuInterval);
  ASSERT_EQ(recording.images.size(), kFixtureFrames);
  EXPECT_EQ(recording.images[2].t_ns, kStart + 2 * kFrameInterval);
  ASSERT_TRUE(recording.image_store);
  for (const std::size_t camera : {1u, 0u}) {
    const EncodedImage image = recording.image_store->load(camera, 3);
    EXPECT_EQ(image.data[18], fixture_pixel(2, 1, 3, static_cast<int>(camera)));
  }
  ASSERT_EQ(recording.truth.motion.states.size(), kFixtureFrames);
  EXPECT_EQ(recording.truth.motion.states[2].p_world_body.x(), 1.0);
  EXPECT_TRUE(recording.odometry.empty()) << "there is an IMU";
  EXPECT_THAT(recording.notes, Contains(HasSubstr("left=/cam0/image_raw,right=/cam1/image_raw")));
}

INSTANTIATE_TEST_SUITE_P(Formats, ReadBag, ::testing::ValuesIn(sound_fixtures()), [](const auto& test) {
  std::string name = test.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

Recording read(const std::string& topics, const StereoCalibration& rig = fixture_rig()) {
  return read_bag(fixture("zstd.mcap"), rig, {}, parse_bag_topics(topics));
}

TEST(AskedTopics, AreTakenAndTheOthersProposed) {
  const Recording recording = read("left=/colour/image_raw,right=/cam1/image_raw/compressed,odometry=/odom");
  EXPECT_EQ(recording.image_store->load(0, 0).encoding, "bgr8");
  EXPECT_TRUE(recording.image_store->load(1, 0).encoding.empty());
  EXPECT_EQ(recording.odometry.size(), kFixtureFrames);
  EXPECT_TRUE(recording.imu.empty()) << "odometry was asked for instead";
  EXPECT_EQ(recording.truth.motion.states.size(), kFixtureFrames);
}

TEST(AskedTopics, ThatAreNotThereOrOfAnotherTypeAreRefused) {
  const auto refused = [](const std::string& topics) {
    return message_of<DataError>([&] { (void)read(topics); });
  };
  EXPECT_THAT(refused("left=/cam0/image_rw,right=/cam1/image_raw"),
              HasSubstr("did you mean /cam0/image_raw?"));
  EXPECT_THAT(refused("left=/imu0,right=/cam1/image_raw"), HasSubstr("/imu0 of type sensor_msgs/Imu"));
  for (const char* const side : {"left", "right"}) {
    EXPECT_THAT(refused(std::string(side) + "=/cam0/image_raw"),
                HasSubstr("two topics of images, left and right, found /cam0/image_raw alone;"));
  }
  EXPECT_THAT(refused("left=/cam0/image_raw,right=/cam0/image_raw"),
              HasSubstr("found /cam0/image_raw for both;"));
  EXPECT_THAT(refused("imu=/chatter"), HasSubstr("std_msgs/String"));
  for (const char* text : {"left", "left=", "middle=/a", "left=/a,left=/b", ""}) {
    EXPECT_THROW((void)parse_bag_topics(text), std::invalid_argument) << text;
  }
  EXPECT_EQ(format_bag_topics(parse_bag_topics("imu=/i,left=/l")), "left=/l,imu=/i");
}

TEST(BagImages, MustHaveTheSizeOfTheCalibration) {
  StereoCalibration rig = fixture_rig();
  rig.cam1.width = 752;
  EXPECT_THAT(message_of<DataError>([&] { (void)read("imu=/imu0", rig); }), HasSubstr("752 x 12 pixels"));
  rig.cam1.width = rig.cam1.height = 0;
  EXPECT_EQ(read("imu=/imu0", rig).calibration.cam1.width, kFixtureWidth) << "the images say it";
}

/// A bag whose images went through `change` on their way.
Recording read_changed(const ImageChange& change, const BagTopics& topics = {}) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.mcap";
  write_bag(read("imu=/imu0"), {path, BagFormat::kMcap, ""}, change);
  return read_bag(path, fixture_rig(), {}, topics);
}

/// The left image of a pair, in half of its rows.
ImageChange halved_from(std::size_t first, std::size_t last) {
  return [=, pair = std::size_t{0}](EncodedImage image, const std::string& place) mutable {
    if (place.find("/cam0/") != std::string::npos) {
      image.height /= pair >= first && pair <= last ? 2 : 1;
      image.data.resize(image.step * static_cast<std::size_t>(image.height));
      ++pair;
    }
    return image;
  };
}

TEST(BagImages, OfAnotherSizeAreSaidAndRefusedWhereMostAreSo) {
  const Recording recording = read_changed(halved_from(2, 2));
  EXPECT_EQ(recording.images.size(), kFixtureFrames);
  EXPECT_THAT(recording.notes,
              Contains(HasSubstr("/cam0/image_raw: images of more than one size or encoding: 1 of 5")));
  const auto refusal = [](const ImageChange& change) {
    return message_of<DataError>([&] { (void)read_changed(change); });
  };
  EXPECT_THAT(refusal(halved_from(1, 4)),
              HasSubstr("images of 16 x 12 pixels, as the calibration says, found 16 x 6"));
  const ImageChange to_depth = [](EncodedImage image, const std::string&) {
    image.encoding = "32FC1";
    return image;
  };
  EXPECT_THAT(refusal(to_depth),
              HasSubstr("left from right: /cam0/image_raw (32FC1), /cam1/image_raw (32FC1);"));
}

TEST(ImuOfABag, IsLeftOutWhereNothingSaysWhereItSits) {
  StereoCalibration rig = fixture_rig();
  rig.body = BodyFrame::kCam0;
  const Recording recording = read("imu=/imu0", rig);
  EXPECT_TRUE(recording.imu.empty());
  EXPECT_THAT(recording.notes, Contains(HasSubstr("does not say where the IMU sits")));
}

/// A bag whose headers have another time in the place of one.
Recording read_restamped(const fs::path& path, std::int64_t from_ns, std::int64_t to_ns) {
  const auto bytes_of = [](std::int64_t t_ns) {
    std::string out;
    for (std::uint64_t part : {t_ns / 1'000'000'000, t_ns % 1'000'000'000}) {
      for (int k = 0; k < 4; ++k, part >>= 8) out += static_cast<char>(part & 0xff);
    }
    return out;
  };
  std::string content = read_text(fixture("unchunked.mcap"));
  for (std::size_t at = content.find(bytes_of(from_ns)); at != std::string::npos;
       at = content.find(bytes_of(from_ns))) {
    content.replace(at, 8, bytes_of(to_ns));
  }
  return read_bag(write_text(path, content), fixture_rig(), ImuNoise{});
}

TEST(StampsOfZero, AmongOthersAreNoneAndTheirMessagesLeftOut) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.mcap";
  for (const std::size_t frame : {0u, 2u}) {
    const Recording recording =
        read_restamped(path, kStart + static_cast<std::int64_t>(frame) * kFrameInterval, 0);
    ASSERT_EQ(recording.images.size(), kFixtureFrames - 1);
    EXPECT_EQ(recording.images.front().t_ns, kStart + (frame == 0 ? kFrameInterval : 0));
    EXPECT_EQ(recording.image_store->load(1, 3).data[0], fixture_pixel(0, 0, 4, 1))
        << "places keep to stamps";
    EXPECT_EQ(recording.imu.size(), kFixtureImu - 1);
    EXPECT_THAT(recording.notes, Contains(HasSubstr("/cam0/image_raw: 1 of 5 messages have no stamp")));
    EXPECT_THAT(inspect(path).notes, Contains(HasSubstr("/imu0: 1 of 41 messages have no stamp")));
  }
}

TEST(StampsThatLeapBack, AreRefusedWithTheTimeOfTheLeap) {
  const TemporaryFolder folder;
  const auto leap = [&] {
    (void)read_restamped(folder.path() / "x.mcap", kStart + 3 * kFrameInterval, kStart - 3'000'000'000);
  };
  EXPECT_THAT(message_of<DataError>(leap), HasSubstr("a jump back by 3.100 s behind " +
                                                     std::to_string(kStart + 2 * kFrameInterval) + " ns"));
}

TEST(TimingOfStamps, CountsGapsStepsBackAndRepetitions) {
  constexpr std::int64_t ms = 1'000'000;
  const Timing timing = timing_of({0, 10 * ms, 20 * ms, 30 * ms, 30 * ms, 25 * ms, 90 * ms, 100 * ms});
  EXPECT_EQ(timing.count, 8u);
  EXPECT_EQ(timing.gaps, 1u);
  EXPECT_DOUBLE_EQ(timing.longest_gap_s, 0.06);
  EXPECT_EQ(timing.longest_gap_at_ns, 30 * ms);
  EXPECT_EQ(timing.backward, 1u);
  EXPECT_DOUBLE_EQ(timing.largest_step_back_s, 0.005);
  EXPECT_EQ(timing.repeated, 1u);
  EXPECT_DOUBLE_EQ(timing.duration_s(), 0.1);
}

TEST(PairsOfTimes, AreTheNearestAndEachImageHasOnePartner) {
  constexpr std::int64_t ms = 1'000'000;
  const PairedTimes paired =
      pair_times({0, 50 * ms, 100 * ms, 150 * ms}, {2 * ms, 51 * ms, 128 * ms, 153 * ms, 154 * ms});
  using Index = std::pair<std::size_t, std::size_t>;
  EXPECT_THAT(paired.pairs, ::testing::ElementsAre(Index{0, 0}, Index{1, 1}, Index{3, 3}));
  EXPECT_DOUBLE_EQ(paired.median_difference_s, 2e-3);
  EXPECT_DOUBLE_EQ(paired.spread_s, 1e-3);
}

TEST(Inspect, SaysWhatABagIsGoodFor) {
  const RecordingInfo info = inspect(fixture("lz4.mcap"));
  EXPECT_EQ(info.format, "MCAP");
  ASSERT_TRUE(info.stereo);
  EXPECT_EQ(info.stereo->pairs, kFixtureFrames);
  EXPECT_TRUE(info.stereo->synchronised());
  EXPECT_EQ(info.topics.truth, "/truth/pose");
  EXPECT_THAT(info.possible, Contains(HasSubstr("--calib camchain.yaml")));
  EXPECT_EQ(info.images->load(0, 4).data[0], fixture_pixel(0, 0, 4, 0));
  const auto imu = std::find_if(info.streams.begin(), info.streams.end(),
                                [](const StreamInfo& stream) { return stream.role == "imu"; });
  ASSERT_NE(imu, info.streams.end());
  EXPECT_DOUBLE_EQ(imu->timing.rate_hz(), 200.0);
  EXPECT_DOUBLE_EQ(*imu->median_delay_s, 0.01);
}

BagStream pictures(const std::string& name, std::size_t count = 3) {
  BagStream out;
  out.topic = {name, "sensor_msgs/Image", Serialization::kRos1, "ros1"};
  out.kind = MessageKind::kImage;
  out.first_image.emplace();
  out.first_image->image.encoding = "mono8";
  out.places.resize(count);
  out.stamps_ns.resize(count);
  return out;
}

TEST(Proposal, TellsLeftFromRightByTheNamesDriversGive) {
  using Names = std::vector<std::string>;
  const auto proposed = [](const Names& names) {
    BagContents contents;
    for (const std::string& name : names) {
      contents.streams.push_back(pictures(name));
    }
    const BagTopics topics = propose_topics(contents).topics;
    return topics.left + " " + topics.right;
  };
  EXPECT_EQ(proposed({"/stereo/right/image_raw", "/stereo/left/image_raw"}),
            "/stereo/left/image_raw /stereo/right/image_raw");
  EXPECT_EQ(
      proposed({"/camera/infra2/image_rect_raw", "/camera/depth/image", "/camera/infra1/image_rect_raw"}),
      "/camera/infra1/image_rect_raw /camera/infra2/image_rect_raw");
  EXPECT_EQ(proposed({"/alphasense/cam1/image", "/alphasense/cam0/image", "/alphasense/cam2/image"}),
            "/alphasense/cam0/image /alphasense/cam1/image");
  EXPECT_EQ(proposed({"/zed/left_rect", "/zed/right_rect", "/zed/left_raw", "/zed/right_raw"}),
            "/zed/left_raw /zed/right_raw");
  EXPECT_EQ(proposed({"/only/image"}), " ");
}

}  // namespace
}  // namespace limber
