// SPDX-License-Identifier: MIT
// Bags and MCAP files that other people's writers made: every message as it went in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fixtures.hpp"
#include "limber/bags/bag_contents.hpp"

namespace limber {
namespace {

using namespace limber::testing;

class ForeignFile : public ::testing::TestWithParam<std::string> {
 protected:
  ForeignFile() : bag(open_bag(fixture(GetParam()))), contents(scan_bag(*bag)) {}
  [[nodiscard]] const BagStream& stream(const std::string& topic) const { return stream_of(contents, topic); }

  std::unique_ptr<BagFile> bag;
  BagContents contents;
};

TEST_P(ForeignFile, IsReadWholeWithTypesAndCounts) {
  EXPECT_TRUE(is_bag(fixture(GetParam())));
  EXPECT_THAT(contents.damages, ::testing::IsEmpty());
  ASSERT_EQ(contents.streams.size(), 9u);
  for (const BagStream& stream : contents.streams) {
    EXPECT_EQ(stream.messages, stream.topic.name == "/imu0" ? kFixtureImu : kFixtureFrames)
        << stream.topic.name;
    EXPECT_EQ(stream.unreadable, 0u) << stream.topic.name;
  }
  EXPECT_EQ(stream("/cam0/image_raw").topic.type, "sensor_msgs/Image");
  EXPECT_EQ(stream("/chatter").kind, MessageKind::kOther);
  EXPECT_EQ(stream("/cam1/image_raw/compressed").kind, MessageKind::kCompressedImage);
}

TEST_P(ForeignFile, GivesImuSamplesBitByBitWithTheStampsOfTheirHeaders) {
  const BagStream& imu = stream("/imu0");
  ASSERT_EQ(imu.imu.size(), kFixtureImu);
  for (std::size_t k = 0; k < imu.imu.size(); ++k) {
    const ImuSample& sample = imu.imu[k].sample;
    const auto n = static_cast<double>(k);
    EXPECT_EQ(sample.t_ns, kStart + static_cast<std::int64_t>(k) * kImuInterval);
    EXPECT_EQ(imu.recorded_ns[k], sample.t_ns + kDelay) << "bag time is another";
    EXPECT_EQ(sample.omega_imu, Eigen::Vector3d(0.001 * n, -0.002 * n, 1.0 / (n + 1.0)));
    EXPECT_EQ(sample.accel_imu, Eigen::Vector3d(0.1, -0.01 * n, 9.81 + 1e-9 * n));
    EXPECT_TRUE(imu.imu[k].has_rates && imu.imu[k].has_accelerations);
  }
}

TEST_P(ForeignFile, GivesImagesPixelByPixelWhenTheyAreAskedFor) {
  for (const int camera : {0, 1}) {
    const BagStream& images = stream(camera == 0 ? "/cam0/image_raw" : "/cam1/image_raw");
    for (std::size_t n : {4u, 0u, 2u}) {
      const auto image = decode_image(bag->read(images.places[n]), images.topic.serialization, images.kind);
      ASSERT_TRUE(image);
      EXPECT_EQ(image->encoding, "mono8");
      ASSERT_EQ(image->width, kFixtureWidth);
      ASSERT_EQ(image->height, kFixtureHeight);
      for (int v = 0; v < image->height; ++v) {
        for (int u = 0; u < image->width; ++u) {
          ASSERT_EQ(image->data[static_cast<std::size_t>(v) * image->step + static_cast<std::size_t>(u)],
                    fixture_pixel(u, v, n, camera));
        }
      }
    }
  }
  const BagStream& colour = stream("/colour/image_raw");
  EXPECT_EQ(colour.first_image->image.encoding, "bgr8");
  EXPECT_EQ(colour.first_image->image.step, 48u);
  const BagStream& png = stream("/cam1/image_raw/compressed");
  const auto image = decode_image(bag->read(png.places[3]), png.topic.serialization, png.kind);
  ASSERT_TRUE(image);
  EXPECT_TRUE(image->encoding.empty());
  EXPECT_EQ(std::string(image->data.begin() + 1, image->data.begin() + 4), "PNG");
}

TEST_P(ForeignFile, GivesPosesAndVelocities) {
  const BagStream &pose = stream("/truth/pose"), &transform = stream("/vicon/body"),
                  &odometry = stream("/odom");
  ASSERT_EQ(pose.poses.size(), kFixtureFrames);
  EXPECT_EQ(pose.poses[3].t_ns, kStart + 3 * kFrameInterval);
  EXPECT_EQ(pose.poses[3].T_world_body.p, Eigen::Vector3d(1.5, 0, 0));
  EXPECT_NEAR(pose.poses[3].T_world_body.R(1, 0), 2 * 0.6 * 0.8, 1e-15) << "quaternions are x y z w";
  EXPECT_EQ(transform.poses[4].T_world_body.p, Eigen::Vector3d(0, 1, 0));
  ASSERT_EQ(odometry.twists.size(), kFixtureFrames);
  EXPECT_EQ(odometry.twists[2].v_body, Eigen::Vector3d(12, 0, 0));
  EXPECT_EQ(odometry.twists[2].omega_body, Eigen::Vector3d(0, 0, 0.25));
}

TEST_P(ForeignFile, TakesOnlyWhatIsWanted) {
  const BagContents some = scan_bag(*bag, [](const BagTopic& topic) { return topic.name == "/imu0"; });
  EXPECT_EQ(stream_of(some, "/imu0").imu.size(), kFixtureImu);
  EXPECT_EQ(stream_of(some, "/cam0/image_raw").messages, kFixtureFrames);
  EXPECT_THAT(stream_of(some, "/cam0/image_raw").places, ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Formats, ForeignFile, ::testing::ValuesIn(sound_fixtures()), [](const auto& test) {
  std::string name = test.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST(UnindexedBag, IsReadLikeAnyOther) {
  const auto bag = open_bag(fixture("ros1_unindexed.bag"));
  const BagContents contents = scan_bag(*bag);
  EXPECT_THAT(contents.damages, ::testing::IsEmpty());
  EXPECT_EQ(stream_of(contents, "/imu0").imu.size(), kFixtureImu);
  EXPECT_EQ(stream_of(contents, "/cam1/image_raw").places.size(), kFixtureFrames);
}

}  // namespace
}  // namespace limber
