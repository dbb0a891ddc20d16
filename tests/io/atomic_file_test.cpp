// SPDX-License-Identifier: MIT
#include "limber/io/atomic_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "datasets/files.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using testing::data_error_of;
using ::testing::ElementsAre;
using testing::files_in;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

TEST(Temporary, HasANameThatNobodyCanForesee) {
  const TemporaryFolder folder;
  const fs::path name = folder.path() / "out.csv";
  std::string first, second;
  {
    const Temporary temporary(name, Temporary::Kind::kFile);
    first = temporary.path().filename().string();
  }
  {
    const Temporary temporary(name, Temporary::Kind::kFile);
    second = temporary.path().filename().string();
  }
  EXPECT_NE(first, second);
  EXPECT_EQ(first.find(std::to_string(getpid())), std::string::npos);
  EXPECT_GE(first.size(), std::string(".out.csv..partial").size() + 16);
}

/// A child that is killed while it writes.
void leave_behind(const fs::path& name, Temporary::Kind kind) {
  const pid_t child = fork();
  if (child == 0) {
    const Temporary temporary(name, kind);
    if (kind == Temporary::Kind::kFolder) {
      write_text(temporary.path() / "half.csv", "half");
    }
    raise(SIGKILL);
  }
  waitpid(child, nullptr, 0);
}

TEST(Temporary, RemovesWhatKilledProcessesLeftButNothingThatIsInUse) {
  const TemporaryFolder folder;
  const fs::path name = folder.path() / "results";
  leave_behind(name, Temporary::Kind::kFile);
  leave_behind(name, Temporary::Kind::kFolder);
  ASSERT_EQ(files_in(folder.path()).size(), 1u) << "the second removed what the first had left";
  const Temporary in_use(name, Temporary::Kind::kFolder);
  EXPECT_THAT(files_in(folder.path()), ElementsAre(in_use.path().filename().string()));
  const Temporary another(name, Temporary::Kind::kFile);
  EXPECT_TRUE(fs::exists(in_use.path()));
  EXPECT_EQ(files_in(folder.path()).size(), 2u);
}

/// Names of that form are never followed as links, nor is what they point to removed.
TEST(Temporary, LeavesLinksOfItsFormAlone) {
  const TemporaryFolder folder;
  const fs::path mine = write_text(folder.path() / "mine", "mine");
  fs::create_symlink(mine, folder.path() / ".out.csv.0000000000000000.partial");
  write_file_atomically(folder.path() / "out.csv", "new");
  EXPECT_EQ(read_text(mine), "mine");
  EXPECT_TRUE(fs::is_symlink(folder.path() / ".out.csv.0000000000000000.partial"));
}

TEST(AtomicFile, RefusesWhatIsNoRegularFile) {
  const TemporaryFolder folder;
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(data_error_of([&] { write_file_atomically(pipe, "x"); }).file(), pipe.string());
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(AtomicFile, OverwritesOnlyWhatIsWritten) {
  const TemporaryFolder folder;
  const fs::path name = folder.path() / "out";
  AtomicFile file(name);
  file.write("head....body");
  file.overwrite(4, "1234");
  file.write(" and tail");
  EXPECT_THROW(file.overwrite(18, "1234"), std::invalid_argument);
  file.overwrite(17, "TAIL");
  file.commit();
  EXPECT_EQ(read_text(name), "head1234body and TAIL");
}

TEST(StagedFolder, PutsTheOlderFolderBackOrAwayAsAWhole) {
  const TemporaryFolder folder;
  const fs::path name = folder.path() / "mav0";
  write_text(name / "old", "old");
  {
    const StagedFolder unfinished(name);
    write_text(unfinished.path() / "new", "new");
  }
  EXPECT_THAT(files_in(name), ElementsAre("old"));
  {
    StagedFolder finished(name);
    write_text(finished.path() / "new", "new");
    finished.replace();
  }
  EXPECT_THAT(files_in(name), ElementsAre("new"));
  EXPECT_THAT(files_in(folder.path()), ElementsAre("mav0"));
}

}  // namespace
}  // namespace limber
