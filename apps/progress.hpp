// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>

namespace limber::app {

/// A progress bar in one line that goes away when the work ends. Nothing at all is written unless the stream
/// is a terminal that can redraw a line.
class Progress {
 public:
  /// @param total what done() counts up to; 0 draws no bar
  Progress(std::string label, std::size_t total, std::FILE* stream = stderr)
      : label_(std::move(label)), total_(total), stream_(stream), draws_(total > 0 && can_redraw(stream)) {}

  ~Progress() {
    if (drawn_) {
      write("\r\x1b[K");
    }
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// So much is done. Cheap: draws at most ten times a second.
  /// @param detail stands between the percentage and the time to go
  void done(std::size_t count, std::string_view detail = "") {
    const auto now = Clock::now();
    if (!draws_ || (drawn_ && now - last_drawn_ < std::chrono::milliseconds(100))) {
      return;
    }
    last_drawn_ = now;
    drawn_ = true;
    const double share = std::min(1.0, static_cast<double>(count) / static_cast<double>(total_));
    const auto filled = static_cast<std::size_t>(share * kWidth);
    write(fmt::format("\r\x1b[K{} [{:#<{}}{:.<{}}] {:3.0f} %{}{}{}", label_, "", filled, "", kWidth - filled,
                      100.0 * share, detail.empty() ? "" : ", ", detail, remaining(share, now)));
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kWidth = 30;

  /// A terminal that has gone away is no reason to stop.
  void write(const std::string& text) const {
    (void)std::fwrite(text.data(), 1, text.size(), stream_);
    (void)std::fflush(stream_);
  }

  static bool can_redraw(std::FILE* stream) {
    const char* terminal = std::getenv("TERM");
    return isatty(fileno(stream)) == 1 && (terminal == nullptr || std::string_view(terminal) != "dumb");
  }

  // Time to go at the pace so far; nothing in the first second, when the pace is a guess.
  [[nodiscard]] std::string remaining(double share, Clock::time_point now) const {
    const double elapsed = std::chrono::duration<double>(now - started_).count();
    if (elapsed < 1.0 || share <= 0.0) {
      return "";
    }
    const double seconds = elapsed * (1.0 - share) / share;
    return seconds < 100.0 ? fmt::format(", {:.0f} s to go", seconds)
                           : fmt::format(", {:.0f} min to go", seconds / 60.0);
  }

  std::string label_;
  std::size_t total_;
  std::FILE* stream_;
  bool draws_;
  bool drawn_ = false;
  Clock::time_point started_ = Clock::now();
  Clock::time_point last_drawn_;
};

}  // namespace limber::app
