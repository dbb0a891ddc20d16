// SPDX-License-Identifier: MIT
// Bags that were cut off, whose bytes flipped, or that lie about their sizes: what is readable is read and
// the rest is said, or the file is refused by name. Nothing crashes, and no memory is taken on a file's word.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "datasets/files.hpp"
#include "fixtures.hpp"
#include "limber/bags/read_bag.hpp"
#include "limber/bags/write_bag.hpp"
#include "limber/core/random.hpp"
#include "true_samples.hpp"

namespace limber {
namespace {

using namespace limber::testing;
using ::testing::HasSubstr;

/// Scans, and reads every image that the scan has found.
BagContents read_all(const fs::path& path) {
  const auto bag = open_bag(path);
  BagContents contents = scan_bag(*bag);
  for (const BagStream& stream : contents.streams) {
    for (const BagPlace& place : stream.places) {
      try {
        (void)decode_image(bag->read(place), stream.topic.serialization, stream.kind);
      } catch (const DataError& error) {
        EXPECT_FALSE(error.file().empty());
      }
    }
  }
  return contents;
}

class DamagedFile : public ::testing::TestWithParam<std::string> {
 protected:
  DamagedFile() : path(folder.path() / GetParam()), content(read_text(fixture(GetParam()))) {}
  const TemporaryFolder folder;
  const fs::path path;
  const std::string content;
};

TEST_P(DamagedFile, ThatWasCutOffIsReadUpToThere) {
  const std::size_t whole = readable_messages(read_all(fixture(GetParam())));
  std::size_t last = 0;
  for (const double share : {0.3, 0.5, 0.7}) {
    write_text(path,
               content.substr(0, static_cast<std::size_t>(share * static_cast<double>(content.size()))));
    try {
      const BagContents contents = read_all(path);
      if (readable_messages(contents) < whole) {  // else the index alone was cut off
        ASSERT_THAT(contents.damages, ::testing::Not(::testing::IsEmpty())) << share;
        EXPECT_THAT(contents.damages, ::testing::SizeIs(1)) << "one place, told once";
        EXPECT_THAT(contents.damages.front(), HasSubstr(path.string()));
      }
      EXPECT_GE(readable_messages(contents), last);
      EXPECT_LE(readable_messages(contents), whole);
      last = readable_messages(contents);
    } catch (const DataError& error) {  // SQLite may not have its tables any more
      EXPECT_THAT(GetParam(), HasSubstr(".db3"));
      EXPECT_EQ(error.file(), path.string());
    }
  }
  if (GetParam().find(".db3") == std::string::npos) {
    EXPECT_GT(last, whole / 4);
  }
}

TEST_P(DamagedFile, WithAHoleIsReadBehindIt) {
  if (GetParam().find(".db3") != std::string::npos) {
    GTEST_SKIP() << "SQLite has pages in place of records";
  }
  const std::size_t whole = readable_messages(read_all(fixture(GetParam())));
  std::vector<BagPlace> places;
  open_bag(fixture(GetParam()))
      ->walk([](const BagTopic&) { return 0; }, [&](const BagMessage& m) { places.push_back(m.place); });
  const BagPlace third = places[places.size() / 3];  // its head, or the content of its chunk
  const std::size_t hole = third.in_chunk ? third.at + 100 : third.at - 31;
  for (const bool indexed : {true, false}) {
    std::string holed = content;
    holed.replace(hole, 40, std::string(40, '\xee'));
    if (!indexed) {  // the end is missing as well, and with it the index
      holed.resize(holed.size() * 9 / 10);
    }
    write_text(path, holed);
    const auto bag = open_bag(path);
    const BagContents contents = scan_bag(*bag);
    EXPECT_FALSE(contents.whole);
    expect_true_samples(contents);
    ASSERT_THAT(contents.damages, ::testing::Not(::testing::IsEmpty()));
    EXPECT_THAT(contents.damages.front(), HasSubstr("bytes are left out, between the messages of "));
    EXPECT_GT(readable_messages(contents), whole / 2) << contents.damages.front();
    EXPECT_LT(readable_messages(contents), whole) << contents.damages.front();
    std::int64_t last = 0;
    for (const BagStream& stream : contents.streams) {
      last = std::max(last, *std::max_element(stream.recorded_ns.begin(), stream.recorded_ns.end()));
    }
    EXPECT_GT(last, kStart + (indexed ? 3 : 2) * kFrameInterval) << "behind the hole";
  }
}

TEST_P(DamagedFile, WhoseBytesFlippedIsReadOrRefused) {
  constexpr std::uint64_t kMutations = 150;
  const RandomStream random(1, 0, GetParam());
  for (std::uint64_t i = 0; i < kMutations; ++i) {
    std::string other = content;
    const std::uint32_t flips = i % 2 == 0 ? 1 : 8;
    for (std::uint32_t k = 0; k < flips; ++k) {
      const auto at = static_cast<std::size_t>(random.uniform(i, 2 * k) * static_cast<double>(other.size()));
      const double value = random.uniform(i, 2 * k + 1);
      other[at] = value < 0.2 ? '\xff' : value < 0.4 ? '\0' : static_cast<char>(256.0 * value);
    }
    if (i % 5 == 0) {
      const auto from = static_cast<std::size_t>(random.uniform(i, 50) * static_cast<double>(other.size()));
      other.erase(from, 1 + from % 37);
    }
    write_text(path, other);
    try {
      (void)read_all(path);
    } catch (const DataError& error) {
      EXPECT_FALSE(error.file().empty());
    } catch (const std::exception& error) {
      ADD_FAILURE() << "mutation " << i << ": " << error.what();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, DamagedFile, ::testing::ValuesIn(sound_fixtures()), [](const auto& test) {
  std::string name = test.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

/// Replaces the first `from` behind `after`.
std::string replaced_behind(std::string text, const std::string& after, std::size_t offset,
                            const std::string& to) {
  const std::size_t at = text.find(after);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at + after.size() + offset, to.size(), to);
}

TEST(HostileBag, GetsNoMemoryForTheSizesItClaims) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.bag";
  for (const char* name : {"ros1_bz2.bag", "ros1_lz4.bag"}) {
    // "size=" of the first chunk, once decompressed: just under what is allowed
    write_text(path,
               replaced_behind(read_text(fixture(name)), "size=", 0, std::string("\xff\xff\xff\x3f", 4)));
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    const BagContents contents = scan_bag(*open_bag(path));
    getrusage(RUSAGE_SELF, &after);
    ASSERT_THAT(contents.damages, ::testing::SizeIs(1));
    EXPECT_THAT(contents.damages.front(), HasSubstr("a damaged chunk"));
    EXPECT_GT(readable_messages(contents), 20u) << "the other chunks are sound";
    EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100'000) << "[kB]";
  }
}

TEST(HostileBag, WithAChunkThatClaimsTooMuchIsReadWithoutIt) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.bag";
  write_text(path, replaced_behind(read_text(fixture("ros1_bz2.bag")), "size=", 0, "\xff\xff\xff\xff"));
  const auto bag = open_bag(path);
  EXPECT_THAT(scan_bag(*bag).damages, ::testing::ElementsAre(HasSubstr("a chunk of 4294967295 bytes")));
}

TEST(UnknownFile, IsRefusedWithWhatItBeginsWith) {
  const TemporaryFolder folder;
  const auto message = [&](std::string_view content) {
    const fs::path path = write_text(folder.path() / "file.bag", content);
    EXPECT_FALSE(is_bag(path));
    try {
      (void)open_bag(path);
    } catch (const DataError& error) {
      EXPECT_EQ(error.file(), path.string());
      return std::string(error.what());
    }
    return std::string("taken");
  };
  EXPECT_THAT(message("#ROSBAG V1.2\n"), HasSubstr("rosbag fix"));
  EXPECT_THAT(message("hello"), HasSubstr("begins with 'hello'"));
  EXPECT_THAT(message(""), HasSubstr("an empty file"));
  EXPECT_FALSE(is_bag(folder.path() / "missing"));
  EXPECT_FALSE(is_bag(folder.path()));
}

/// A record of 8 bytes of which somebody has overwritten one: the n-th byte behind the first `text`.
struct Overwritten {
  const char* file;
  std::string text;
  std::ptrdiff_t offset;
  char value;
};

TEST(DamagedHead, OfOneChunkCostsNoMoreThanThatChunk) {
  const TemporaryFolder folder;
  const std::string op("op=\x05", 4), zstd("\x04\0\0\0zstd", 8);
  const Overwritten cases[] = {{"ros1_lz4.bag", op, 3, '\x45'},  // another opcode
                               {"ros1_lz4.bag", op, 0, 'x'},     // a header without opcode
                               {"ros1_lz4.bag", "compression=", -1, '\x7f'},
                               {"zstd.mcap", zstd, -37, '\x46'},  // opcode
                               {"zstd.mcap", zstd, -34, '\x7f'},  // length: beyond the end
                               {"zstd.mcap", zstd, -35, '\x01'},  // length: into the next chunk, or shorter
                               {"zstd.mcap", zstd, 6, 'x'}};      // "zsxd"
  for (const Overwritten& one : cases) {
    const std::string sound = read_text(fixture(one.file));
    const std::size_t first = sound.find(one.text), second = sound.find(one.text, first + 1);
    ASSERT_NE(second, std::string::npos);
    std::string other = sound;
    SCOPED_TRACE(std::string(one.file) + " " + std::to_string(one.offset));
    other[second + static_cast<std::size_t>(one.offset)] = one.value;
    const fs::path path = write_text(folder.path() / one.file, other);
    const BagContents contents = scan_bag(*open_bag(path)), whole = scan_bag(*open_bag(fixture(one.file)));
    EXPECT_FALSE(contents.whole);
    expect_true_samples(contents);
    EXPECT_THAT(contents.damages, ::testing::SizeIs(1));
    EXPECT_GT(2 * readable_messages(contents), readable_messages(whole));
    EXPECT_LT(readable_messages(contents), readable_messages(whole));
    for (const BagStream& stream : contents.streams) {
      EXPECT_EQ(timing_of(stream.recorded_ns).repeated, 0u) << "no message twice";
    }
  }
}

/// Images of noise, which no compressor shrinks: what stands between them stands in the file as it is.
EncodedImage noise(EncodedImage, const std::string& place) {
  EncodedImage out;
  out.encoding = "mono8";
  out.width = 512;
  out.height = 400;
  out.step = 512;
  const RandomStream random(1, 0, place);
  for (std::uint64_t k = 0; k < 512 * 400; ++k) {
    out.data.push_back(static_cast<std::uint8_t>(256.0 * random.uniform(k)));
  }
  return out;
}

TEST(DamagedHead, OfACompressedChunkGivesNoFalseMessages) {
  const TemporaryFolder folder;
  StereoCalibration rig;
  rig.theta(3) = -0.1;
  rig.body = BodyFrame::kImu;
  const Recording recording = read_bag(fixture("ros1_none.bag"), rig, ImuNoise{});
  const fs::path path = folder.path() / "noise.bag";
  write_bag(recording, {path, BagFormat::kRos1, "lz4"}, noise);
  std::string content = read_text(path);
  const std::size_t second = content.find("compression=lz4", content.find("compression=lz4") + 20);
  ASSERT_NE(second, std::string::npos);
  content.replace(second, 11, "xxxxxxxxxxx");
  for (const bool indexed : {true, false}) {
    write_text(path, content.substr(0, content.size() - (indexed ? 0 : 2000)));
    const BagContents contents = scan_bag(*open_bag(path));
    EXPECT_FALSE(contents.whole);
    EXPECT_GT(stream_of(contents, "/imu0").imu.size(), 0u);
    EXPECT_LT(stream_of(contents, "/imu0").imu.size(), kFixtureImu);
    expect_true_samples(contents);
  }
}

TEST(SeveralFiles, OfARos2BagAreOne) {
  const TemporaryFolder folder;
  write_text(folder.path() / "x_9.mcap", read_text(fixture("zstd.mcap")));
  write_text(folder.path() / "x_10.mcap", read_text(fixture("lz4.mcap")));
  write_text(folder.path() / "metadata.yaml", "rosbag2_bagfile_information:\n");
  ASSERT_TRUE(is_bag(folder.path()));
  const auto bag = open_bag(folder.path());
  const BagContents contents = scan_bag(*bag);
  EXPECT_EQ(contents.streams.size(), 9u);
  EXPECT_TRUE(contents.whole);
  EXPECT_THAT(contents.damages,
              ::testing::ElementsAre(HasSubstr("2 of them, x_9.mcap to x_10.mcap, are read as one")));
  const BagStream& images = stream_of(contents, "/cam0/image_raw");
  ASSERT_EQ(images.places.size(), 2 * kFixtureFrames);
  EXPECT_EQ(images.places[3].file, 0u);
  EXPECT_EQ(images.places[7].file, 1u);
  EXPECT_EQ(bag->read(images.places[2]), bag->read(images.places[7]));
  fs::create_directory(folder.path() / "mav0");
  EXPECT_FALSE(is_bag(folder.path())) << "an EuRoC folder with a bag in it";
}

class ListedFiles : public ::testing::Test {
 protected:
  void list(const std::string& lines) const {
    write_text(folder.path() / "metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n" + lines);
  }
  const TemporaryFolder folder;
  const fs::path a = write_text(folder.path() / "a.mcap", read_text(fixture("zstd.mcap"))),
                 b = write_text(folder.path() / "b.mcap", read_text(fixture("lz4.mcap")));
};

TEST_F(ListedFiles, AreReadInTheOrderOfTheList) {
  list("  relative_file_paths:\n    - b.mcap\n    - a.mcap\n");
  const auto bag = open_bag(folder.path());
  std::vector<std::size_t> sizes;
  bag->walk([](const BagTopic&) { return 0; }, [&](const BagMessage& m) { sizes.push_back(m.place.at); });
  const auto first = open_bag(b);
  std::vector<std::size_t> expected;
  first->walk([](const BagTopic&) { return 0; },
              [&](const BagMessage& m) { expected.push_back(m.place.at); });
  ASSERT_EQ(sizes.size(), 2 * expected.size());
  sizes.resize(expected.size());
  EXPECT_EQ(sizes, expected);
  EXPECT_TRUE(bag->is_whole());
}

TEST_F(ListedFiles, ThatAreMissingAreNamedAndTheOthersRead) {
  list("  relative_file_paths:\n    - a.mcap\n    - gone.mcap\n");
  const BagContents contents = scan_bag(*open_bag(folder.path()));
  EXPECT_FALSE(contents.whole);
  EXPECT_THAT(contents.damages, ::testing::ElementsAre(HasSubstr("gone.mcap is listed in metadata.yaml"),
                                                       HasSubstr("b.mcap is not listed")));
  EXPECT_EQ(stream_of(contents, "/imu0").imu.size(), kFixtureImu);
}

TEST_F(ListedFiles, OfOlderBagsAreNamedWithTheirFolder) {
  list("  relative_file_paths:\n    - name_of_old/b.mcap\n");
  EXPECT_EQ(stream_of(scan_bag(*open_bag(folder.path())), "/imu0").imu.size(), kFixtureImu);
}

TEST_F(ListedFiles, OutsideTheFolderOrInAnotherCompressionAreRefused) {
  list("  relative_file_paths:\n    - ../b.mcap\n");
  EXPECT_EQ(data_error_of([&] { (void)open_bag(folder.path()); }).file(),
            (folder.path() / "metadata.yaml").string());
  list("  compression_mode: FILE\n  compression_format: lz5\n  relative_file_paths:\n    - a.mcap\n");
  EXPECT_THAT(data_error_of([&] { (void)open_bag(folder.path()); }).what(),
              HasSubstr("compression_format zstd, or none, found 'lz5'"));
}

TEST_F(ListedFiles, OfABrokenListAreReadByName) {
  write_text(folder.path() / "metadata.yaml", "rosbag2_bagfile_information: [\n");
  const BagContents contents = scan_bag(*open_bag(folder.path()));
  EXPECT_TRUE(contents.whole);
  EXPECT_EQ(stream_of(contents, "/imu0").imu.size(), 2 * kFixtureImu);
}

TEST(PackedFile, IsABagByWhatIsInIt) {
  const TemporaryFolder folder;
  fs::copy_file(fixture("ros2_file.db3.zstd"), folder.path() / "bag_0.db3.zstd");
  EXPECT_TRUE(is_bag(folder.path()));
  EXPECT_EQ(open_bag(folder.path())->format(), "ROS 2 bag (sqlite3), zstd");
  const std::string other("\x28\xb5\x2f\xfd\x24\x03\x19\0\0abc\x1e\x6e\x4d\x17", 16);
  EXPECT_FALSE(is_bag(write_text(folder.path() / "text.zstd", other)));
}

TEST(PackedFile, LeavesNothingInTheFolderForTemporaryFiles) {
  const TemporaryFolder temporary;
  setenv("TMPDIR", temporary.path().c_str(), 1);
  {
    const auto bag = open_bag(fixture("ros2_file.db3.zstd"));
    EXPECT_THAT(files_in(temporary.path()), ::testing::SizeIs(1));
  }
  EXPECT_THAT(files_in(temporary.path()), ::testing::IsEmpty());
  unsetenv("TMPDIR");
}

}  // namespace
}  // namespace limber
