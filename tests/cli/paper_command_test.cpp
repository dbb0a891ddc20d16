// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/run_program.hpp"

namespace limber {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::run_limber;
using testing::TemporaryFolder;

TEST(PaperCommand, ComputesOneFigureAndLaterMore) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "paper").string();
  const auto ten = run_limber({"paper", "--figure", "10", "--runs", "1", "--three-methods", "--out", out});
  EXPECT_EQ(ten.exit_code, 0) << ten.err;
  EXPECT_THAT(
      ten.out,
      AllOf(
          HasSubstr("Figure 10, paper_v_strong: 1 of 1 runs, started from the truth (--init groundtruth)\n"),
          HasSubstr("| lcekf:full |"), Not(HasSubstr("oracle"))));
  EXPECT_THAT(ten.err, HasSubstr("3 runs, 3 of them now"));

  const auto six = run_limber({"paper", "--figure", "6", "--figure", "10", "--runs", "1", "--three-methods",
                               "--out", out, "--export", "json"});
  EXPECT_EQ(six.exit_code, 0) << six.err;
  EXPECT_THAT(six.err, HasSubstr("6 runs, 3 of them now"));
  EXPECT_THAT(
      six.out,
      HasSubstr("Figures 6 and 12, paper_ii: 1 of 1 runs, started from the truth (--init groundtruth)\n"));
  EXPECT_TRUE(std::filesystem::exists(out + "/paper.sqlite"));
  EXPECT_TRUE(std::filesystem::exists(out + "/paper.json"));

  // The same case with other methods is another study.
  const auto mixed = run_limber({"paper", "--figure", "10", "--runs", "1", "--out", out});
  EXPECT_EQ(mixed.exit_code, 1);
  EXPECT_THAT(mixed.err, HasSubstr("now:      - oracle"));
}

TEST(PaperCommand, RefusesFiguresThatDoNotExist) {
  for (const std::string figure : {"2", "19", "ten", "-5"}) {
    const auto result = run_limber({"paper", "--figure", figure, "--out", "/tmp/never"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr("expected a figure with results, 3 to 18, found '" + figure + "'"));
  }
  EXPECT_EQ(run_limber({"paper"}).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists("/tmp/never"));
}

TEST(PaperCommand, FailsAtOnceWhereItCannotWrite) {
  const TemporaryFolder folder;
  const auto file = testing::write_text(folder.path() / "file", "mine");
  const auto result = run_limber({"paper", "--out", file.string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("expected a folder that can be made and written"));
}

}  // namespace
}  // namespace limber
