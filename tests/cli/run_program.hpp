// SPDX-License-Identifier: MIT
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "datasets/files.hpp"

namespace limber::testing {

/// What a run of the program left behind.
struct ProgramResult {
  int exit_code = 0;  ///< minus the signal's number if one ended it
  std::string out, err;
};

inline std::string shell_quoted(const std::string& argument) {
  std::string quoted = "'";
  for (const char c : argument) {
    quoted += c == '\'' ? "'\\''" : std::string(1, c);
  }
  return quoted + "'";
}

/// The shell command that runs `limber` with these arguments.
inline std::string limber_command(const std::vector<std::string>& arguments) {
  std::string command = shell_quoted(LIMBER_PROGRAM);
  for (const std::string& argument : arguments) {
    command += " " + shell_quoted(argument);
  }
  return command;
}

/// Runs a shell command, neither stdout nor stderr a terminal. `redirect` may send stdout elsewhere.
inline ProgramResult run_command(std::string command, const std::string& redirect = "") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out", err = folder.path() / "err";
  command += " >" + shell_quoted(out.string()) + " 2>" + shell_quoted(err.string()) + " " + redirect;
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_text(out), read_text(err)};
}

/// Starts `limber`, silent, and sends it the signal after so many milliseconds.
/// @return whether the signal ended it; false if it was done before
inline bool start_and_kill_limber(const std::vector<std::string>& arguments, int signal, int after_ms) {
  std::vector<const char*> argv = {LIMBER_PROGRAM};
  for (const std::string& argument : arguments) {
    argv.push_back(argument.c_str());
  }
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    std::signal(signal, SIG_DFL);  // a shell ignores Ctrl-C for what it starts in the background
    execv(LIMBER_PROGRAM, const_cast<char* const*>(argv.data()));
    _exit(127);
  }
  if (child < 0) {
    return false;
  }
  usleep(static_cast<useconds_t>(1000 * after_ms));
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) && WTERMSIG(status) == signal;
}

/// Runs `limber` with these arguments, see run_command.
inline ProgramResult run_limber(const std::vector<std::string>& arguments, const std::string& redirect = "") {
  return run_command(limber_command(arguments), redirect);
}

/// Names of all files below a folder, sorted by the file system's whim: for "nothing was left behind".
inline std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    names.push_back(fs::relative(entry.path(), folder).string());
  }
  return names;
}

}  // namespace limber::testing
