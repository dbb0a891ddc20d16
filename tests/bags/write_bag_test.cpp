// SPDX-License-Identifier: MIT
// What goes into an MCAP file, a ROS 1 bag or an EuRoC folder comes out bit by bit.
#include "limber/bags/write_bag.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/files.hpp"
#include "fixtures.hpp"
#include "limber/bags/read_bag.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/image_files.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/write_euroc.hpp"

namespace limber {
namespace {

using namespace limber::testing;

StereoCalibration small_rig() {
  StereoCalibration out;
  out.cam0.width = out.cam1.width = kFixtureWidth;
  out.cam0.height = out.cam1.height = kFixtureHeight;
  out.cam0.fu = out.cam0.fv = out.cam1.fu = out.cam1.fv = 20.0;
  out.theta(3) = -0.1;
  return out;
}

constexpr const char* kTopics =
    "left=/cam0/image_raw,right=/cam1/image_raw/compressed,imu=/imu0,odometry=/odom,truth=/truth/pose";

Recording of_a_bag(const fs::path& path, const char* topics = kTopics) {
  return read_bag(path, small_rig(), ImuNoise{}, parse_bag_topics(topics));
}

void expect_same(const Recording& a, const Recording& b) {
  ASSERT_EQ(a.imu.size(), b.imu.size());
  for (std::size_t k = 0; k < a.imu.size(); ++k) {
    EXPECT_EQ(a.imu[k].t_ns, b.imu[k].t_ns);
    EXPECT_EQ(a.imu[k].omega_imu, b.imu[k].omega_imu);
    EXPECT_EQ(a.imu[k].accel_imu, b.imu[k].accel_imu);
  }
  ASSERT_EQ(a.odometry.size(), b.odometry.size());
  for (std::size_t k = 0; k < a.odometry.size(); ++k) {
    EXPECT_EQ(a.odometry[k].t_ns, b.odometry[k].t_ns);
    EXPECT_EQ(a.odometry[k].v_body, b.odometry[k].v_body);
    EXPECT_EQ(a.odometry[k].omega_body, b.odometry[k].omega_body);
  }
  ASSERT_EQ(a.truth.motion.states.size(), b.truth.motion.states.size());
  for (std::size_t k = 0; k < a.truth.motion.states.size(); ++k) {
    EXPECT_EQ(a.truth.motion.states[k].t_ns, b.truth.motion.states[k].t_ns);
    EXPECT_EQ(a.truth.motion.states[k].p_world_body, b.truth.motion.states[k].p_world_body);
    EXPECT_TRUE(a.truth.motion.states[k].R_world_body.isApprox(b.truth.motion.states[k].R_world_body, 1e-14));
  }
  ASSERT_EQ(a.images.size(), b.images.size());
  for (std::size_t n = 0; n < a.images.size(); ++n) {
    EXPECT_EQ(a.images[n].t_ns, b.images[n].t_ns);
  }
}

/// Every format and compression.
std::vector<BagOutput> outputs(const fs::path& folder) {
  std::vector<BagOutput> out;
  for (const auto& [format, ending] : {std::pair{BagFormat::kMcap, ".mcap"}, {BagFormat::kRos1, ".bag"}}) {
    for (const std::string_view compression : compressions_of(format)) {
      out.push_back({folder / (std::string(compression) + ending), format, std::string(compression)});
    }
  }
  return out;
}

TEST(BagRoundTrip, KeepsImuOdometryStampsAndImagesBitByBit) {
  const TemporaryFolder folder;
  const Recording before = of_a_bag(fixture("ros1_bz2.bag"));
  for (const BagOutput& output : outputs(folder.path())) {
    SCOPED_TRACE(output.path);
    write_bag(before, output);
    EXPECT_TRUE(scan_bag(*open_bag(output.path)).damages.empty());
    const Recording after = of_a_bag(output.path,
                                     "left=/cam0/image_raw,right=/cam1/image_raw/compressed,imu=/imu0,"
                                     "odometry=/odometry,truth=/groundtruth");
    expect_same(before, after);
    for (std::size_t n = 0; n < before.images.size(); ++n) {
      for (const std::size_t camera : {0u, 1u}) {
        const EncodedImage a = before.image_store->load(camera, n), b = after.image_store->load(camera, n);
        EXPECT_EQ(a.data, b.data);
        EXPECT_EQ(a.encoding, b.encoding);
        EXPECT_EQ(a.step, b.step);
      }
    }
  }
  EXPECT_EQ(files_in(folder.path()).size(), 6u);
}

TEST(WriteBag, CompressesAsItWasAsked) {
  const TemporaryFolder folder;
  const Recording recording = of_a_bag(fixture("ros1_none.bag"));
  for (const BagOutput& output : outputs(folder.path())) {
    write_bag(recording, output);
  }
  const auto size = [&](const char* name) { return fs::file_size(folder.path() / name); };
  EXPECT_LT(size("lz4.bag"), size("none.bag"));
  EXPECT_LT(size("bz2.bag"), size("lz4.bag"));
  EXPECT_LT(size("zstd.mcap"), size("lz4.mcap"));
  EXPECT_LT(size("lz4.mcap"), size("none.mcap"));
  const BagOutput unknown{folder.path() / "x.bag", BagFormat::kRos1, "zstd"};
  EXPECT_THROW(write_bag(recording, unknown), std::invalid_argument);
}

constexpr const char* kRealFileLeft =
    "left=/cam1/image_raw/compressed,right=/cam0/image_raw,imu=/imu0,odometry=/odom,truth=/truth/pose";

/// A PNG is made by nobody here: the pixels themselves, in a file that calls itself one.
std::vector<std::uint8_t> not_really_png(const EncodedImage& image, const std::string&) { return image.data; }

TEST(EurocRoundTrip, KeepsImuOdometryStampsAndImageFilesBitByBit) {
  const TemporaryFolder folder;
  const Recording before = of_a_bag(fixture("lz4.mcap"), kRealFileLeft);
  // The reader looks at the first image: both cameras must have real files.
  Recording both = before;
  struct Twice final : ImageStore {
    std::shared_ptr<const ImageStore> from;
    EncodedImage load(std::size_t, std::size_t pair) const override { return from->load(0, pair); }
    std::string place(std::size_t, std::size_t pair) const override { return from->place(0, pair); }
  };
  auto twice = std::make_shared<Twice>();
  twice->from = before.image_store;
  both.image_store = twice;
  write_euroc(both, folder.path(), not_really_png);
  const Recording after = read_recording(folder.path());
  expect_same(both, after);
  const auto images = stored_images(after);
  for (std::size_t n = 0; n < both.images.size(); ++n) {
    EXPECT_EQ(images->load(0, n).data, before.image_store->load(0, n).data);
    EXPECT_EQ(after.images[n].cam0.extension(), ".png");
  }
}

TEST(WriteEuroc, ReplacesItsOwnFoldersOnlyAndOnlyWhenTold) {
  const TemporaryFolder folder;
  const Recording recording = of_a_bag(fixture("zstd.mcap"));
  write_euroc(recording, folder.path(), not_really_png);
  EXPECT_THROW(write_euroc(recording, folder.path(), not_really_png), DataError);
  write_euroc(recording, folder.path(), not_really_png, true);
  write_text(folder.path() / "mav0/cam0/sensor.yaml", "somebody's\n");
  EXPECT_THROW(write_euroc(recording, folder.path(), not_really_png, true), DataError);
  EXPECT_EQ(read_text(folder.path() / "mav0/cam0/sensor.yaml"), "somebody's\n");
}

/// The left images of a bag for both cameras; those of the right one from a pair to another are broken.
struct BrokenRight final : ImageStore {
  std::shared_ptr<const ImageStore> from;
  std::size_t first = 0, last = 0;

  EncodedImage load(std::size_t camera, std::size_t pair) const override {
    if (camera == 1 && pair >= first && pair <= last) {
      throw DataError("x.bag", 0, "a sound image", "a torn one");
    }
    return from->load(0, pair);
  }
  std::string place(std::size_t, std::size_t pair) const override { return from->place(0, pair); }
};

Recording with_broken_images(std::size_t first, std::size_t last) {
  Recording out = of_a_bag(fixture("zstd.mcap"), kRealFileLeft);
  auto store = std::make_shared<BrokenRight>();
  store->from = out.image_store;
  store->first = first;
  store->last = last;
  out.image_store = store;
  return out;
}

TEST(AnImageThatCannotBeRead, IsLeftOutOfACopyThatHoldsAllOthers) {
  const TemporaryFolder folder;
  const Recording broken = with_broken_images(2, 2);
  const auto expect_lost = [&](const std::vector<LostImage>& lost) {
    ASSERT_EQ(lost.size(), 1u);
    EXPECT_EQ(lost[0].camera, 1u);
    EXPECT_EQ(lost[0].t_ns, broken.images[2].t_ns);
    EXPECT_THAT(lost[0].why, ::testing::HasSubstr("x.bag: expected a sound image, found a torn one"));
  };
  const BagOutput output{folder.path() / "x.mcap", BagFormat::kMcap, ""};
  expect_lost(write_bag(broken, output));
  const BagContents contents = scan_bag(*open_bag(output.path));
  EXPECT_EQ(stream_of(contents, "/cam0/image_raw/compressed").messages, broken.images.size());
  EXPECT_EQ(stream_of(contents, "/cam1/image_raw/compressed").messages, broken.images.size() - 1);

  expect_lost(write_euroc(broken, folder.path(), not_really_png));
  EXPECT_EQ(files_in(folder.path() / "mav0/cam0/data").size(), broken.images.size());
  const Recording after = read_recording(folder.path());
  EXPECT_EQ(after.images.size(), broken.images.size() - 1);
  EXPECT_EQ(after.imu.size(), broken.imu.size());
}

TEST(AnImageThatCannotBeRead, EndsACopyWhereAllOfItsCameraAreSo) {
  const TemporaryFolder folder;
  const Recording broken = with_broken_images(0, of_a_bag(fixture("zstd.mcap")).images.size());
  for (const BagOutput& output : outputs(folder.path())) {
    EXPECT_THROW(write_bag(broken, output), DataError);
  }
  EXPECT_THROW(write_euroc(broken, folder.path() / "x", not_really_png), DataError);
  EXPECT_TRUE(files_in(folder.path()).empty());
}

TEST(StoppedWriting, LeavesNothingBehind) {
  const TemporaryFolder folder;
  const Recording recording = of_a_bag(fixture("zstd.mcap"));
  std::size_t asked = 0;
  const auto stop = [&asked] { return ++asked == 3; };
  for (const BagOutput& output : outputs(folder.path())) {
    asked = 0;
    EXPECT_THROW(write_bag(recording, output, {}, {}, stop), std::runtime_error);
  }
  asked = 0;
  EXPECT_THROW(write_euroc(recording, folder.path() / "x", not_really_png, false, {}, stop),
               std::runtime_error);
  EXPECT_TRUE(files_in(folder.path()).empty());
}

}  // namespace
}  // namespace limber
