// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "commands.hpp"
#include "limber/core/nearest_word.hpp"
#include "messages.hpp"
#include "version.hpp"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

using limber::app::print_error;
using limber::app::print_note;

std::string did_you_mean(const std::string& word, const std::vector<std::string>& known) {
  const auto meant = limber::nearest_word(word, known);
  return meant ? ", did you mean " + *meant + "?" : "";
}

std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    names.push_back(option->get_name());
  }
  return names;
}

// CLI11's message, or a plainer one.
std::string what_is_wrong(const CLI::App& command, const CLI::ParseError& error) {
  const std::string message = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const auto extras = command.remaining();
    if (extras.empty()) {
      return message;
    }
    const auto option =
        std::find_if(extras.begin(), extras.end(), [](const std::string& text) { return text[0] == '-'; });
    return option != extras.end()
               ? "unknown option " + *option +
                     did_you_mean(option->substr(0, option->find('=')), options_of(command))
               : "unexpected argument: " + extras.front();
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    const std::string name = message.substr(0, message.find(':'));
    if (const CLI::Option* option = command.get_option_no_throw(name)) {
      return name + (option->count() > 1 ? " is given more than once" : " needs a value");
    }
  }
  return message;
}

// The commands that were typed, one within the other.
std::vector<const CLI::App*> chosen_commands(const CLI::App& app) {
  std::vector<const CLI::App*> out;
  for (auto below = app.get_subcommands(); !below.empty(); below = out.back()->get_subcommands()) {
    out.push_back(below.front());
  }
  return out;
}

// What was wrong with the command line, and what to type next.
int report_usage(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<const CLI::App*> chosen = chosen_commands(app);
  std::string commands;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
    commands += (commands.empty() ? "" : ", ") + names.back();
  }
  // CLI11 complains of the missing command before it looks at what stands in its place.
  const auto unexpected = app.remaining();
  print_error(chosen.empty() && !unexpected.empty()
                  ? "unknown: " + unexpected.front() + did_you_mean(unexpected.front(), names)
                  : what_is_wrong(chosen.empty() ? app : *chosen.back(), error));
  if (chosen.empty()) {
    print_note("expected one of the commands: " + commands);
  }
  std::string words;
  for (const CLI::App* command : chosen) {
    words += command->get_name() + " ";
  }
  print_note("try: limber " + words + "--help");
  return limber::app::kExitUsage;
}

int run(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      throw std::runtime_error("standard output cannot be written");
    }
    return limber::app::kExitDone;
  } catch (const CLI::RuntimeError& result) {
    return result.get_exit_code();
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    return report_usage(app, error);
  } catch (const std::bad_alloc&) {
    print_error("not enough memory: fewer points a frame or a smaller --max-landmarks need less");
    return limber::app::kExitFailed;
  } catch (const std::filesystem::filesystem_error& error) {
    print_error(error.path1().string() + ": " + error.code().message());
    return limber::app::kExitFailed;
  } catch (const std::exception& error) {
    print_error(error.what());
    return limber::app::kExitFailed;
  }
}

// Every frame's large matrices come and go. What is freed stays with the program, instead of going back to
// the kernel, which would clear it each time (a tenth of a run). 32 MiB is the most that every glibc accepts.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 25);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

// A standard stream that is closed would hand its number to the next file that is opened, and messages would
// be written into a database. Writing to what stands in for it fails, as it should.
void open_standard_streams() {
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
    if (fcntl(descriptor, F_GETFD) == -1) {
      (void)open("/dev/null", O_RDONLY);  // takes the lowest free number
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of writing, as on a full disk
  keep_freed_memory();
  CLI::App app{"limber: stereo navigation for rigs that bend", "limber"};
  app.set_version_flag("--version", limber::app::version_text(), "Print version, commit and parts, and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.require_subcommand(1);
  app.footer(
      "\nExit codes: 0 done, 1 failed, 2 wrong usage; health and recalibrate have more, see their help.\n"
      "Messages go to stderr, results to stdout.\n"
      "Example:\n  limber evaluate runs/v101/trajectory.csv data/v101");
  limber::app::add_run_command(app);
#ifdef LIMBER_WITH_SMOOTHER
  limber::app::add_smooth_command(app);
  limber::app::add_recalibrate_command(app);
#endif
  limber::app::add_health_command(app);
  limber::app::add_info_command(app);
  limber::app::add_convert_command(app);
  limber::app::add_simulate_command(app);
#ifdef LIMBER_WITH_FRONTEND
  limber::app::add_decalibrate_command(app);
#endif
  limber::app::add_evaluate_command(app);
  limber::app::add_compare_command(app);
  limber::app::add_study_command(app);
  limber::app::add_paper_command(app);
  limber::app::add_report_command(app);
  return run(app, argc, argv);
}
