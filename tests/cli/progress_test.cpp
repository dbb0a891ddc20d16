// SPDX-License-Identifier: MIT
#include "progress.hpp"

#include <gtest/gtest.h>
#include <pty.h>
#include <termios.h>

#include <array>
#include <cstdio>
#include <string>

namespace limber::app {
namespace {

// A terminal whose screen the test reads.
class Terminal {
 public:
  Terminal() {
    int terminal = -1;
    if (openpty(&screen_, &terminal, nullptr, nullptr, nullptr) == 0) {
      stream_ = fdopen(terminal, "w");
    }
  }
  ~Terminal() {
    if (stream_ != nullptr) {
      std::fclose(stream_);
      close(screen_);
    }
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  [[nodiscard]] std::FILE* stream() const { return stream_; }

  // What was written so far; call it only after something was.
  [[nodiscard]] std::string written() const {
    std::array<char, 4096> buffer{};
    const auto size = read(screen_, buffer.data(), buffer.size());
    return {buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
  }

 private:
  int screen_ = -1;
  std::FILE* stream_ = nullptr;
};

TEST(Progress, DrawsOnATerminalAndClearsTheLineAtTheEnd) {
  setenv("TERM", "xterm", 1);
  const Terminal terminal;
  if (terminal.stream() == nullptr) {
    GTEST_SKIP() << "no pseudo-terminal to be had";
  }
  {
    Progress progress("simulating", 200, terminal.stream());
    progress.done(50);
    EXPECT_EQ(terminal.written(), "\r\x1b[Ksimulating [#######.......................]  25 %");
    progress.done(51);  // too soon to draw again
  }
  EXPECT_EQ(terminal.written(), "\r\x1b[K");
}

TEST(Progress, ShowsADetailBehindThePercentage) {
  setenv("TERM", "xterm", 1);
  const Terminal terminal;
  if (terminal.stream() == nullptr) {
    GTEST_SKIP() << "no pseudo-terminal to be had";
  }
  Progress progress("study.sqlite", 10, terminal.stream());
  progress.done(5, "3 of 6 runs, 0.5 runs/s");
  EXPECT_EQ(terminal.written(),
            "\r\x1b[Kstudy.sqlite [###############...............]  50 %, 3 of 6 runs, 0.5 runs/s");
}

TEST(Progress, IsQuietWhenPiped) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  {
    Progress progress("simulating", 200, file);
    progress.done(100);
    progress.done(200);
  }
  EXPECT_EQ(std::ftell(file), 0);
  std::fclose(file);
}

TEST(Progress, IsQuietOnATerminalThatCannotRedraw) {
  setenv("TERM", "dumb", 1);
  const Terminal terminal;
  if (terminal.stream() == nullptr) {
    GTEST_SKIP() << "no pseudo-terminal to be had";
  }
  {
    Progress progress("simulating", 200, terminal.stream());
    progress.done(100);
  }
  std::fputs("end", terminal.stream());
  std::fflush(terminal.stream());
  EXPECT_EQ(terminal.written(), "end");
}

TEST(Progress, WithNothingToCountDrawsNothing) {
  setenv("TERM", "xterm", 1);
  const Terminal terminal;
  if (terminal.stream() == nullptr) {
    GTEST_SKIP() << "no pseudo-terminal to be had";
  }
  { Progress("nothing", 0, terminal.stream()).done(0); }
  std::fputs("end", terminal.stream());
  std::fflush(terminal.stream());
  EXPECT_EQ(terminal.written(), "end");
}

}  // namespace
}  // namespace limber::app
