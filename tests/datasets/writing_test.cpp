// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

#include "files.hpp"
#include "limber/datasets/landmarks_ply.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/io/atomic_file.hpp"
#include "small_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;

using testing::data_error_of;
using testing::read_text;
using testing::replaced;
using testing::TemporaryFolder;
using testing::write_text;

std::ptrdiff_t entries(const fs::path& folder) { return std::distance(fs::directory_iterator(folder), {}); }

TEST(AtomicFile, AppearsOnlyWhenCommitted) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "out.csv";
  AtomicFile file(path);
  file.write("one\n");
  file.write(std::string_view("t\0o\n", 4));
  EXPECT_FALSE(fs::exists(path));
  file.commit();
  EXPECT_EQ(read_text(path), std::string("one\nt\0o\n", 8));
  EXPECT_EQ(entries(folder.path()), 1);
}

TEST(AtomicFile, LeavesTheOlderFileAndNothingElseWithoutCommit) {
  const TemporaryFolder folder;
  const fs::path path = write_text(folder.path() / "out.csv", "old");
  {
    AtomicFile file(path);
    file.write("half of the n");
  }
  EXPECT_EQ(read_text(path), "old");
  EXPECT_EQ(entries(folder.path()), 1);
  write_file_atomically(path, "new");
  EXPECT_EQ(read_text(path), "new");
  EXPECT_EQ(entries(folder.path()), 1);
}

TEST(AtomicFile, TwoWritersOfOneNameDoNotMix) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "out.csv";
  AtomicFile first(path), second(path);
  first.write("first");
  second.write("second");
  first.commit();
  EXPECT_EQ(read_text(path), "first");
  second.commit();
  EXPECT_EQ(read_text(path), "second");
}

TEST(AtomicFile, NamesAPlaceThatCannotBeWritten) {
  const TemporaryFolder folder;
  const fs::path nowhere = folder.path() / "nowhere" / "out.csv";
  const DataError error = data_error_of([&] { write_file_atomically(nowhere, "x"); });
  EXPECT_EQ(error.file(), nowhere.string());
  EXPECT_NE(std::string(error.what()).find("No such file or directory"), std::string::npos) << error.what();
  EXPECT_EQ(data_error_of([&] { write_file_atomically(folder.path(), "x"); }).file(), folder.path().string());
  EXPECT_EQ(data_error_of([&] { write_tum(nowhere, {}); }).file(), nowhere.string());
  EXPECT_EQ(data_error_of([&] { write_trajectory_csv(nowhere, {}); }).file(), nowhere.string());
  EXPECT_EQ(data_error_of([&] { write_landmarks_ply(nowhere, {}); }).file(), nowhere.string());
  EXPECT_EQ(entries(folder.path()), 0);
}

TEST(AtomicFile, LeavesNothingOnAFullDisk) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "out.csv";
  {
    const testing::SmallDisk disk;
    EXPECT_EQ(data_error_of([&] { write_file_atomically(path, std::string(100'000, 'x')); }).file(),
              path.string());
    EXPECT_EQ(data_error_of([&] { write_file_atomically(path, std::string(1'001, 'x')); }).file(),
              path.string());
    EXPECT_NO_THROW(write_file_atomically(path, std::string(1'000, 'x')));
  }
  EXPECT_EQ(fs::file_size(path), 1'000U);
  EXPECT_EQ(entries(folder.path()), 1);
}

TEST(TrackLogWriter, LeavesNothingOnAFullDisk) {
  const TemporaryFolder folder;
  Recording recording = testing::small_recording();
  for (std::int64_t k = 0; k < 100; ++k) {
    recording.frames.back().observations.push_back({1000 + k, {1, 2}, {3, 4}, true, true});
  }
  {
    const testing::SmallDisk disk;
    EXPECT_EQ(data_error_of([&] { write_track_log(recording, folder.path()); }).file(),
              (folder.path() / "mav0/tracks0/data.csv").string());
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(FolderUnlessEmpty, GoesAwayWithTheParentsItMadeUnlessSomethingIsInIt) {
  const TemporaryFolder folder;
  { const FolderUnlessEmpty made(folder.path() / "a" / "b" / "c"); }
  EXPECT_TRUE(fs::is_empty(folder.path()));
  {
    const FolderUnlessEmpty made(folder.path() / "a" / "b");
    testing::write_text(folder.path() / "a" / "file", "kept");
  }
  EXPECT_TRUE(fs::exists(folder.path() / "a" / "file"));
  EXPECT_FALSE(fs::exists(folder.path() / "a" / "b"));
  { const FolderUnlessEmpty older(folder.path() / "a"); }
  EXPECT_TRUE(fs::exists(folder.path() / "a"));
}

TEST(FolderUnlessEmpty, LeavesNothingWhereItCannotBeMade) {
  const TemporaryFolder folder;
  testing::write_text(folder.path() / "file", "mine");
  EXPECT_THROW(FolderUnlessEmpty(folder.path() / "file" / "below"), fs::filesystem_error);
  EXPECT_THROW(FolderUnlessEmpty(folder.path() / "a" / std::string(300, 'x')), fs::filesystem_error);
  EXPECT_EQ(entries(folder.path()), 1);
}

TEST(LandmarksPly, HoldsIdAndPositionOfEachPoint) {
  const TemporaryFolder folder;
  write_landmarks_ply(folder.path() / "landmarks.ply", {{12, {1.5, -2, 0.1}}, {-7, {1e-9, 0, 3}}});
  EXPECT_EQ(
      read_text(folder.path() / "landmarks.ply"),
      "ply\nformat ascii 1.0\ncomment landmarks in the world frame [m], id = track_id\nelement vertex 2\n"
      "property float x\nproperty float y\nproperty float z\nproperty int id\nend_header\n"
      "1e-09 0 3 -7\n1.5 -2 0.1 12\n");
}

TEST(LandmarksPly, MakesRoomForLongIds) {
  const TemporaryFolder folder;
  write_landmarks_ply(folder.path() / "landmarks.ply", {{5'000'000'000, {0, 0, 0}}});
  const std::string text = read_text(folder.path() / "landmarks.ply");
  EXPECT_NE(text.find("property double id\nend_header\n0 0 0 5000000000\n"), std::string::npos) << text;
}

TEST(LandmarksPly, IsReadBack) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "landmarks.ply";
  const std::map<std::int64_t, Eigen::Vector3d> landmarks = {{12, {1.5, -2, 0.125}},
                                                             {5'000'000'000, {0, 0, 3}}};
  write_landmarks_ply(path, landmarks);
  EXPECT_EQ(read_landmarks_ply(path), landmarks);
  write_landmarks_ply(path, {});
  EXPECT_TRUE(read_landmarks_ply(path).empty());
}

TEST(LandmarksPly, IsReadWithColumnsInAnyOrder) {
  const TemporaryFolder folder;
  const fs::path path =
      write_text(folder.path() / "l.ply",
                 "ply\nformat ascii 1.0\nelement vertex 1\nproperty int id\nproperty uchar red\n"
                 "property float z\nproperty float x\nproperty float y\nend_header\n7 255 3 1 2\n");
  EXPECT_EQ(read_landmarks_ply(path), (std::map<std::int64_t, Eigen::Vector3d>{{7, {1, 2, 3}}}));
}

TEST(LandmarksPly, NamesTheLineThatIsWrong) {
  const TemporaryFolder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property int id\nend_header\n";
  const std::vector<std::pair<std::string, std::size_t>> bad = {
      {"obj\n", 1},
      {replaced(head, "ascii", "binary_little_endian"), 2},
      {replaced(head, "vertex 2", "vertex -2"), 3},
      {replaced(head, "property int id\n", ""), 7},
      {head + "0 0 0 1\n", 10},
      {head + "0 0 0 1\n0 0 0\n", 10},
      {head + "0 0 0 1\n0 nan 0 2\n", 10},
      {head + "0 0 0 1\n0 0 0 1\n", 10},
  };
  for (const auto& [text, line] : bad) {
    const DataError error = data_error_of(
        [&, &text = text] { (void)read_landmarks_ply(write_text(folder.path() / "l.ply", text)); });
    EXPECT_EQ(error.line(), line) << text;
  }
}

TEST(LandmarksPly, IsNotWrittenWithAPointNowhere) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_landmarks_ply(folder.path() / "l.ply", {{1, {0, std::nan(""), 0}}}),
               std::invalid_argument);
  EXPECT_THROW(write_landmarks_ply(folder.path() / "l.ply", {{1, {0, 1e300, 0}}}), std::invalid_argument);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace limber
