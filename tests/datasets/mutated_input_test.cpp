// SPDX-License-Identifier: MIT
// Files that were cut, or whose bytes flipped: a reader takes them or throws a DataError, and nothing else.
#include <gtest/gtest.h>

#include <filesystem>

#include "files.hpp"
#include "limber/core/random.hpp"
#include "limber/datasets/landmarks_ply.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/track_log.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "small_recording.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

constexpr std::uint64_t kMutations = 60;  // of each file

/// Cut somewhere, some bytes replaced, a piece doubled, or a piece left out.
std::string mutated(const std::string& text, const RandomStream& random, std::uint64_t i) {
  const auto place = [&](std::uint32_t j) {
    return static_cast<std::size_t>(random.uniform(i, j) * static_cast<double>(text.size()));
  };
  const std::size_t a = std::min(place(1), place(2)), b = std::max(place(1), place(2));
  switch (i % 4) {
    case 0:
      return text.substr(0, a);
    case 1: {
      std::string out = text;
      constexpr std::string_view kBytes = ",-.e9[]{}:#&*!\n \t\"'%0x";
      for (std::uint32_t k = 0; k < 3; ++k) {
        const double which = random.uniform(i, 20 + k);
        out[place(10 + k)] = k == 2 ? static_cast<char>(256.0 * which)
                                    : kBytes[static_cast<std::size_t>(which * kBytes.size())];
      }
      return out;
    }
    case 2:
      return text.substr(0, b) + text.substr(a);
    default:
      return text.substr(0, a) + text.substr(b);
  }
}

/// Calls `read` after each mutation of `file`.
void mutate_and_read(const fs::path& file, const std::function<void()>& read) {
  const std::string text = read_text(file);
  ASSERT_FALSE(text.empty());
  const RandomStream random(1, 0, file.filename().string());
  for (std::uint64_t i = 0; i < kMutations; ++i) {
    const std::string other = mutated(text, random, i);
    write_text(file, other);
    try {
      read();
    } catch (const DataError& error) {
      EXPECT_FALSE(error.file().empty());
    } catch (const std::exception& error) {
      ADD_FAILURE() << file << ", mutation " << i << ": " << error.what() << "\n" << other.substr(0, 2000);
    }
  }
  write_text(file, text);
}

TEST(MutatedInput, OfATrackLogIsTakenOrRefusedWithItsFile) {
  const TemporaryFolder folder;
  write_track_log(testing::small_recording(), folder.path());
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (entry.is_regular_file()) {
      files.push_back(entry.path());
    }
  }
  EXPECT_GE(files.size(), 10u);
  for (const fs::path& file : files) {
    mutate_and_read(file, [&] { (void)read_recording(folder.path()); });
  }
}

TEST(MutatedInput, OfTrajectoriesAndMapsIsTakenOrRefusedWithItsFile) {
  const TemporaryFolder folder;
  const fs::path tum = folder.path() / "t.tum", csv = folder.path() / "t.csv", ply = folder.path() / "l.ply";
  write_tum(tum, {{1, {}}, {2, {}}, {1'000'000'000, {}}});
  TrajectoryRow moving, bare;
  moving.t_ns = 1;
  moving.v_world_body = Eigen::Vector3d(1, 2, 3);
  moving.sigma_v = Eigen::Vector3d(0.1, 0.2, 0.3);
  bare.t_ns = 2;
  write_trajectory_csv(csv, {moving, bare});
  write_landmarks_ply(ply, {{1, {1, 2, 3}}, {7, {0.1, -2, 1e9}}});
  mutate_and_read(tum, [&] { (void)read_trajectory(tum); });
  mutate_and_read(csv, [&] { (void)read_trajectory(csv); });
  mutate_and_read(ply, [&] { (void)read_landmarks_ply(ply); });
}

}  // namespace
}  // namespace limber
