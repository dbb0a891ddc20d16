// SPDX-License-Identifier: MIT
// ROS 2 bags in SQLite with damaged pages, and messages that are packed one by one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "datasets/files.hpp"
#include "fixtures.hpp"
#include "limber/bags/read_bag.hpp"
#include "true_samples.hpp"

namespace limber {
namespace {

using namespace limber::testing;
using ::testing::HasSubstr;

/// Where the pages of a database begin that hold rows of a table.
std::vector<std::size_t> leaf_pages(const std::string& content) {
  constexpr std::size_t kPage = 4096;
  constexpr char kTableLeaf = 0x0d;
  std::vector<std::size_t> out;
  for (std::size_t at = kPage; at + kPage <= content.size(); at += kPage) {
    if (content[at] == kTableLeaf) {
      out.push_back(at);
    }
  }
  return out;
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
