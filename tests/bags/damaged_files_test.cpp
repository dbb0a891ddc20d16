// SPDX-License-Identifier: MIT
// Bags that were cut off, whose bytes flipped, or that lie about their sizes: what is readable is read and
// the rest is said, or the file is refused by name. Nothing crashes, and no memory is taken on a file's word.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "datasets/files.hpp"
#include "fixtures.hpp"
#include "limber/core/random.hpp"

namespace limber {
namespace {

using namespace limber::testing;
using ::testing::HasSubstr;

std::size_t readable_messages(const BagContents& contents) {
  std::size_t out = 0;
  for (const BagStream& stream : contents.streams) {
    out += stream.stamps_ns.size();
  }
  return out;
}

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
  if (GetParam() != "ros2.db3") {
    EXPECT_GT(last, whole / 4);
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

TEST(SeveralFiles, OfARos2BagAreOne) {
  const TemporaryFolder folder;
  write_text(folder.path() / "x_9.mcap", read_text(fixture("zstd.mcap")));
  write_text(folder.path() / "x_10.mcap", read_text(fixture("lz4.mcap")));
  write_text(folder.path() / "metadata.yaml", "rosbag2_bagfile_information:\n");
  ASSERT_TRUE(is_bag(folder.path()));
  const auto bag = open_bag(folder.path());
  const BagContents contents = scan_bag(*bag);
  EXPECT_EQ(contents.streams.size(), 9u);
  const BagStream& images = stream_of(contents, "/cam0/image_raw");
  ASSERT_EQ(images.places.size(), 2 * kFixtureFrames);
  EXPECT_EQ(images.places[3].file, 0u);
  EXPECT_EQ(images.places[7].file, 1u);
  EXPECT_EQ(bag->read(images.places[2]), bag->read(images.places[7]));
  fs::create_directory(folder.path() / "mav0");
  EXPECT_FALSE(is_bag(folder.path())) << "an EuRoC folder with a bag in it";
}

}  // namespace
}  // namespace limber
