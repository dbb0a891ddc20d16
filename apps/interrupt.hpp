// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <csignal>

namespace limber::app {

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
