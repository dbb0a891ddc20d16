// SPDX-License-Identifier: MIT
// ROS 2 bags in SQLite with damaged pages, and messages that are packed one by one.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/files.hpp"
#include "fixtures.hpp"
#include "io/sqlite.hpp"
#include "limber/bags/read_bag.hpp"
#include "limber/core/random.hpp"
#include "true_samples.hpp"

namespace limber {
namespace {

using namespace limber::testing;
using ::testing::HasSubstr;

constexpr char kTableLeaf = 0x0d, kTableInterior = 0x05;

/// Where the pages of a database begin that are of a type.
std::vector<std::size_t> pages_of(const std::string& content, char type, std::size_t size) {
  std::vector<std::size_t> out;
  for (std::size_t at = size; at + size <= content.size(); at += size) {
    if (content[at] == type) {
      out.push_back(at);
    }
  }
  return out;
}

/// Those that hold rows of a table.
std::vector<std::size_t> leaf_pages(const std::string& content) {
  return pages_of(content, kTableLeaf, 4096);
}

std::size_t imu_samples(const BagContents& contents) { return stream_of(contents, "/imu0").imu.size(); }

TEST(DamagedPage, OfADatabaseCostsNoMoreThanItsRows) {
  const TemporaryFolder folder;
  const std::string sound = read_text(fixture("ros2.db3"));
  const BagContents whole = scan_bag(*open_bag(fixture("ros2.db3")));
  const auto leaves = leaf_pages(sound);
  ASSERT_GE(leaves.size(), 3u);
  std::size_t inside = 0;
  for (const std::size_t leaf : leaves) {
    std::string other = sound;
    other.replace(leaf, 4096, std::string(4096, '\xee'));
    const fs::path path = write_text(folder.path() / "x.db3", other);
    BagContents contents;
    try {
      contents = scan_bag(*open_bag(path));
    } catch (const DataError& error) {  // of the table of topics
      EXPECT_EQ(error.file(), path.string());
      continue;
    }
    if (readable_messages(contents) == readable_messages(whole)) {
      continue;  // of another table
    }
    EXPECT_FALSE(contents.whole);
    EXPECT_GT(2 * readable_messages(contents), readable_messages(whole)) << leaf;
    expect_true_samples(contents);
    ASSERT_THAT(contents.damages, ::testing::SizeIs(1)) << "one page, told once";
    EXPECT_THAT(contents.damages.front(), HasSubstr("a damaged page (database disk image is malformed)"));
    inside += contents.damages.front().find("between the messages of") != std::string::npos ? 1 : 0;
  }
  EXPECT_GE(inside, 1u) << "a page with rows on both sides";
}

TEST(DamagedPage, TwoOfThemKeepWhatStandsBetween) {
  const TemporaryFolder folder;
  std::string other = read_text(fixture("ros2.db3"));
  const std::size_t whole = readable_messages(scan_bag(*open_bag(fixture("ros2.db3"))));
  std::vector<std::size_t> of_messages;
  for (const std::size_t leaf : leaf_pages(other)) {
    std::string one = other;
    one.replace(leaf, 4096, std::string(4096, '\0'));
    try {
      const BagContents contents = scan_bag(*open_bag(write_text(folder.path() / "y.db3", one)));
      if (!contents.whole) of_messages.push_back(leaf);
    } catch (const DataError&) {
      continue;
    }
  }
  ASSERT_GE(of_messages.size(), 3u);
  for (const std::size_t leaf : {of_messages.front(), of_messages.back()}) {
    other.replace(leaf, 4096, std::string(4096, '\0'));
  }
  const BagContents contents = scan_bag(*open_bag(write_text(folder.path() / "x.db3", other)));
  EXPECT_THAT(contents.damages, ::testing::SizeIs(2));
  EXPECT_GT(readable_messages(contents), 0u);
  EXPECT_LT(readable_messages(contents), whole);
  EXPECT_GT(imu_samples(contents), 0u);
  expect_true_samples(contents);
}

constexpr std::size_t kSmallPage = 512;

/// The messages of ros2.db3 four times, on small pages: below the root of the tree stand others that lead to
/// its rows. Images go over several pages.
std::string deep_bag(const fs::path& path, const std::string& last_command = "") {
  write_text(path, read_text(fixture("ros2.db3")));
  detail::SqliteFile file(path, detail::SqliteFile::Mode::kCreate, "a bag");
  for (int k = 0; k < 2; ++k) {
    file.execute(
        "INSERT INTO messages(topic_id, timestamp, data) SELECT topic_id, timestamp, data FROM messages");
  }
  file.execute(fmt::format("PRAGMA page_size = {}; VACUUM; PRAGMA secure_delete = OFF", kSmallPage));
  if (!last_command.empty()) {
    file.execute(last_command);
  }
  return read_text(path);
}

/// Topic, bag time and all bytes of every message, in order.
std::vector<std::string> all_messages(const fs::path& path) {
  const auto bag = open_bag(path);
  std::vector<std::pair<std::string, BagPlace>> found;
  bag->walk([](const BagTopic&) { return 24; },
            [&](const BagMessage& message) {
              found.emplace_back(fmt::format("{} {} ", bag->topics()[message.topic].name, message.t_ns),
                                 message.place);
            });
  std::vector<std::string> out;
  for (auto& [text, place] : found) {
    const auto data = bag->read(place);
    out.push_back(text.append(data.begin(), data.end()));
  }
  return out;
}

TEST(InteriorPage, ThatIsDamagedHidesNoRow) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.db3";
  const std::string sound = deep_bag(path);
  const auto whole = all_messages(path);
  const auto interior = pages_of(sound, kTableInterior, kSmallPage);
  ASSERT_GE(interior.size(), 3u) << "a root, and more than one page below it";
  for (const std::size_t page : interior) {
    std::string other = sound;
    other.replace(page, kSmallPage, std::string(kSmallPage, '\xee'));
    EXPECT_EQ(all_messages(write_text(path, other)), whole) << page;
    const BagContents contents = scan_bag(*open_bag(path));
    EXPECT_FALSE(contents.whole);
    ASSERT_THAT(contents.damages, ::testing::SizeIs(1));
    EXPECT_THAT(contents.damages.front(), HasSubstr("are read from their own pages, to which it led"));
    EXPECT_THAT(contents.damages.front(), ::testing::Not(HasSubstr("left out")));
  }
}

TEST(InteriorPage, ThatIsDamagedBesideALeafCostsTheRowsOfThat) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.db3";
  std::string other = deep_bag(path);
  const auto whole = all_messages(path);
  const auto leaves = pages_of(other, kTableLeaf, kSmallPage);
  for (const std::size_t page : pages_of(other, kTableInterior, kSmallPage)) {
    other.replace(page, kSmallPage, std::string(kSmallPage, '\0'));
  }
  other.replace(leaves[leaves.size() / 2], kSmallPage, std::string(kSmallPage, '\0'));
  const auto read = all_messages(write_text(path, other));
  EXPECT_LT(read.size(), whole.size());
  EXPECT_GE(read.size() + 3, whole.size()) << "a page of 512 bytes holds few rows";
  EXPECT_THAT(read, ::testing::Each(::testing::AnyOfArray(whole)));
  EXPECT_THAT(scan_bag(*open_bag(path)).damages,
              ::testing::ElementsAre(HasSubstr("are left out, between the messages of ")));
}

TEST(InteriorPage, ThatIsDamagedRaisesNoDeletedRow) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.db3";
  const std::string sound = deep_bag(path, "DELETE FROM messages WHERE id BETWEEN 30 AND 120");
  const auto whole = all_messages(path);
  EXPECT_LT(whole.size(), all_messages(fixture("ros2.db3")).size() * 4 - 80);
  const auto interior = pages_of(sound, kTableInterior, kSmallPage);
  const auto with_all_broken = [&](std::string other) {
    for (const std::size_t page : interior) {
      other.replace(page, kSmallPage, std::string(kSmallPage, '\xee'));
    }
    return all_messages(write_text(path, other));
  };
  EXPECT_EQ(with_all_broken(sound), whole) << "by the list of free pages";
  std::string other = sound;
  other.replace(32, 4, std::string(4, '\x7f'));
  EXPECT_THAT(with_all_broken(other), ::testing::IsEmpty()) << "without that list nothing is taken";
}

/// Of a long message a flipped byte may be one of its own, which nothing tells: one message each at most.
TEST(InteriorPage, WhoseFileHasFlippedBytesGivesNoMoreMessagesAndNoOthersButForThoseBytes) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "x.db3";
  std::string sound = deep_bag(path);
  const auto whole = all_messages(path);
  for (const std::size_t page : pages_of(sound, kTableInterior, kSmallPage)) {
    sound.replace(page, kSmallPage, std::string(kSmallPage, '\xee'));
  }
  const RandomStream random(1, 0, "pages");
  for (std::uint64_t i = 0; i < 60; ++i) {
    std::string other = sound;
    const std::uint64_t flips = 1 + i % 40;
    for (std::uint64_t k = 0; k < flips; ++k) {  // heads of pages and cells, where structure is
      const auto page =
          static_cast<std::size_t>(random.uniform(i, 3 * k) * static_cast<double>(sound.size())) / kSmallPage;
      const auto at = page * kSmallPage + static_cast<std::size_t>(random.uniform(i, 3 * k + 1) * 12.0);
      if (page > 0) other[at] = static_cast<char>(256.0 * random.uniform(i, 3 * k + 2));
    }
    try {
      const auto read = all_messages(write_text(path, other));
      EXPECT_LE(read.size(), whole.size());
      const auto others = std::ranges::count_if(
          read, [&](const std::string& message) { return std::ranges::find(whole, message) == whole.end(); });
      EXPECT_LE(others, static_cast<std::ptrdiff_t>(flips));
    } catch (const DataError& error) {
      EXPECT_EQ(error.file(), path.string());
    }
  }
}

TEST(PackedMessage, BeginsAsTheWholeOfItDoes) {
  const auto bag = open_bag(fixture("ros2_messages.db3"));
  std::vector<std::pair<BagPlace, std::vector<std::uint8_t>>> heads;
  bag->walk(
      [](const BagTopic&) { return 24; },
      [&](const BagMessage& m) { heads.emplace_back(m.place, std::vector(m.data.begin(), m.data.end())); });
  std::size_t longer = 0;
  for (const auto& [place, head] : heads) {
    const auto message = bag->read(place);
    EXPECT_EQ(message.size(), place.size);
    EXPECT_GT(place.packed_size, 0u);
    ASSERT_EQ(head.size(), std::min<std::size_t>(24, message.size()));
    EXPECT_TRUE(std::equal(head.begin(), head.end(), message.begin()));
    longer += message.size() > head.size() ? 1 : 0;
  }
  EXPECT_GT(longer, kFixtureImu);
}

}  // namespace
}  // namespace limber
