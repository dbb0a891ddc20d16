// SPDX-License-Identifier: MIT
#pragma once

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include "datasets/files.hpp"

namespace limber::testing {

/// `limber` running beside the test: to be watched, and ended.
class ChildProcess {
 public:
  /// @param file_limit size that no file it writes may exceed [bytes]
  explicit ChildProcess(std::vector<std::string> arguments, std::optional<rlim_t> file_limit = {}) {
    arguments.insert(arguments.begin(), LIMBER_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) {
      argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    const std::string err = err_path().string();
    pid_ = fork();
    if (pid_ == 0) {
      dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
      dup2(open(err.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
      if (file_limit) {
        const rlimit limit{*file_limit, *file_limit};
        setrlimit(RLIMIT_FSIZE, &limit);
        std::signal(SIGXFSZ, SIG_IGN);  // writing fails, as on a full disk, instead of ending the process
      }
      execv(argv[0], argv.data());
      _exit(127);
    }
  }
  ~ChildProcess() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      wait();
    }
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void signal(int number) const {
    if (pid_ > 0) {  // else everybody would get it
      kill(pid_, number);
    }
  }

  /// @return its exit code, or minus the number of the signal that ended it
  int wait() {
    int status = 0;
    wait4(pid_, &status, 0, &usage_);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  /// After wait().
  [[nodiscard]] std::string err() const { return read_text(err_path()); }
  [[nodiscard]] double peak_rss_mb() const { return static_cast<double>(usage_.ru_maxrss) / 1024.0; }

 private:
  [[nodiscard]] fs::path err_path() const { return folder_.path() / "err"; }

  const TemporaryFolder folder_;
  pid_t pid_ = -1;
  rusage usage_{};
};

}  // namespace limber::testing
