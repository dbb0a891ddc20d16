// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/run_program.hpp"

namespace limber {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::run_limber;
using ::testing::StartsWith;

TEST(Usage, VersionGoesToStdout) {
  const auto result = run_limber({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, StartsWith("limber 0."));
  EXPECT_THAT(result.out, HasSubstr("\ncommit "));
  EXPECT_THAT(result.out, HasSubstr("\nwith "));
  EXPECT_THAT(result.err, IsEmpty());
}

TEST(Usage, HelpNamesTheCommandsAndShowsAnExample) {
  const auto result = run_limber({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("evaluate"));
  EXPECT_THAT(result.out, HasSubstr("Example:\n  limber "));
  EXPECT_THAT(result.err, IsEmpty());
}

TEST(Usage, HelpOfEachCommandShowsAnExample) {
  for (const std::string command : {"run", "simulate", "evaluate", "report", "compare", "study", "paper"}) {
    const auto result = run_limber({command, "--help"});
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_THAT(result.out, HasSubstr("Example:\n  limber " + command));
    EXPECT_THAT(result.err, IsEmpty()) << command;
  }
}

TEST(Usage, NoCommandIsWrongUsage) {
  const auto result = run_limber({});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.out, IsEmpty());
  EXPECT_THAT(result.err, StartsWith("limber: error: "));
  EXPECT_THAT(
      result.err,
      HasSubstr("expected one of the commands: run, smooth, recalibrate, health, info, convert, simulate"));
  EXPECT_THAT(result.err, HasSubstr("try: limber --help"));
}

TEST(Usage, AnUnknownCommandIsNamed) {
  const auto result = run_limber({"evalute"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("unknown: evalute, did you mean evaluate?"));
  EXPECT_THAT(
      result.err,
      HasSubstr("expected one of the commands: run, smooth, recalibrate, health, info, convert, simulate"));
}

TEST(Usage, AnUnknownOptionIsNamedWithTheHelpOfItsCommand) {
  const auto result = run_limber({"evaluate", "a", "b", "--frobnicate"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.out, IsEmpty());
  EXPECT_THAT(result.err, HasSubstr("--frobnicate"));
  EXPECT_THAT(result.err, HasSubstr("try: limber evaluate --help"));
}

TEST(Usage, WhatIsTooMuchBehindACommandWithinACommandIsNamed) {
  const auto surplus = run_limber({"study", "show", "a.sqlite", "b.sqlite"});
  EXPECT_EQ(surplus.exit_code, 2);
  EXPECT_THAT(surplus.err, HasSubstr("unexpected argument: b.sqlite"));
  EXPECT_THAT(surplus.err, HasSubstr("try: limber study show --help"));
  const auto unknown = run_limber({"study", "show", "a.sqlite", "--runs", "1"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("unknown option --runs"));
}

TEST(Usage, AMissingArgumentIsNamed) {
  const auto result = run_limber({"evaluate", "a"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("GROUNDTRUTH is required"));
  EXPECT_THAT(result.err, HasSubstr("try: limber evaluate --help"));
}

TEST(Usage, ValuesThatMakeNoSenseAreWrongUsage) {
  for (const std::string value : {"nan", "inf", "0", "-3", "ten", ""}) {
    const auto result = run_limber({"evaluate", "a", "b", "--rpe-distance", value});
    EXPECT_EQ(result.exit_code, 2) << value;
    EXPECT_THAT(result.err, HasSubstr("expected a positive number, found '" + value + "'"));
  }
}

TEST(Usage, OutputThatCannotBeWrittenIsAFailure) {
  if (!std::filesystem::exists("/dev/full")) {
    GTEST_SKIP() << "there is no /dev/full here";
  }
  const testing::TemporaryFolder folder;
  const auto square =
      testing::write_text(folder.path() / "a.txt", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 1 1 0 0 0 0 1\n");
  const auto result = run_limber({"evaluate", square.string(), square.string()}, ">/dev/full");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("limber: error: "));
}

}  // namespace
}  // namespace limber
