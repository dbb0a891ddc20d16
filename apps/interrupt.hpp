// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <csignal>
#include <exception>

namespace limber::app {

/// Ends work of which nothing is worth keeping before it is whole.
class Stopped final : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "stopped: nothing is written"; }
};

/// While it lives, the first Ctrl-C (or SIGTERM) only asks to stop; the second one ends the program. One may
/// live within another: what was asked stays asked as long as the outer one lives.
class Interrupt {
 public:
  Interrupt() {
    if (depth()++ > 0) {
      return;
    }
    requested() = false;
    for (const int signal : {SIGINT, SIGTERM}) {
      std::signal(signal, handle);
    }
  }
  ~Interrupt() {
    if (--depth() > 0) {
      return;
    }
    for (const int signal : {SIGINT, SIGTERM}) {
      std::signal(signal, SIG_DFL);
    }
  }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] static bool asked() { return requested(); }
  /// @throws Stopped if it was asked
  static void check() {
    if (asked()) {
      throw Stopped();
    }
  }

 private:
  static int& depth() {
    static int count = 0;
    return count;
  }
  static std::atomic<bool>& requested() {
    static std::atomic<bool> flag = false;
    return flag;
  }
  static void handle(int signal) {
    requested() = true;
    std::signal(signal, SIG_DFL);
  }
};

}  // namespace limber::app
