// SPDX-License-Identifier: MIT
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/run_program.hpp"
#include "limber/datasets/track_log.hpp"
#include "run/short_recording.hpp"

namespace limber::testing {

/// A folder with a track log of two seconds in it, and the program to run on it.
class SmallLog : public ::testing::Test {
 protected:
  SmallLog() { write_track_log(short_recording(), log()); }

  [[nodiscard]] fs::path folder() const { return folder_.path(); }
  [[nodiscard]] fs::path log() const { return folder_.path() / "log"; }
  [[nodiscard]] fs::path mav0() const { return log() / "mav0"; }
  [[nodiscard]] fs::path out() const { return folder_.path() / "out"; }

  /// `limber run` on the log, into `out`, with more arguments.
  [[nodiscard]] ProgramResult run_into(const fs::path& out, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"run", log().string(), "--out", out.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_limber(arguments);
  }
  [[nodiscard]] ProgramResult run(const std::vector<std::string>& more = {}) const {
    return run_into(out(), more);
  }
  /// The same, over what an earlier one has written.
  [[nodiscard]] ProgramResult run_again(std::vector<std::string> more = {}) const {
    more.emplace_back("--force");
    return run(more);
  }

 private:
  TemporaryFolder folder_;
};

/// The program failed with this exit code, said so on stderr alone, and in words.
inline void expect_refused(const ProgramResult& result, int exit_code, const std::string& words) {
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  EXPECT_THAT(result.out, ::testing::IsEmpty());
  EXPECT_THAT(result.err, ::testing::HasSubstr("limber: error: "));
  EXPECT_THAT(result.err, ::testing::HasSubstr(words));
}

}  // namespace limber::testing
