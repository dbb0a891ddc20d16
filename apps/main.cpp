// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#include "commands.hpp"
#include "messages.hpp"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

using limber::app::print_error;
using limber::app::print_note;

// CLI11's message, or a plainer one.
std::string what_is_wrong(const CLI::App& command, const CLI::ParseError& error) {
  const std::string message = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    const auto extras = command.remaining();
    const auto option =
        std::find_if(extras.begin(), extras.end(), [](const std::string& text) { return text[0] == '-'; });
    return option != extras.end() ? "unknown option " + *option : "unexpected argument: " + extras.front();
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    const std::string name = message.substr(0, message.find(':'));
    if (const CLI::Option* option = command.get_option_no_throw(name)) {
      return name + (option->count() > 1 ? " is given more than once" : " needs a value");
    }
  }
  return message;
}

// What was wrong with the command line, and what to type next.
int report_usage(const CLI::App& app, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  std::string commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    commands += (commands.empty() ? "" : ", ") + command->get_name();
  }
  // CLI11 complains of the missing command before it looks at what stands in its place.
  const auto unexpected = app.remaining();
  print_error(chosen.empty() && !unexpected.empty()
                  ? "unknown: " + unexpected.front()
                  : what_is_wrong(chosen.empty() ? app : *chosen.front(), error));
  if (chosen.empty()) {
    print_note("expected one of the commands: " + commands);
  }
  print_note("try: limber " + (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help");
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

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  CLI::App app{"limber: stereo navigation for rigs that bend", "limber"};
  app.set_version_flag("--version", "limber " LIMBER_VERSION, "Print the version and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.require_subcommand(1);
  app.footer(
      "\nExit codes: 0 done, 1 failed, 2 wrong usage. Messages go to stderr, results to stdout.\n"
      "Example:\n  limber evaluate runs/v101/trajectory.csv data/v101");
  limber::app::add_run_command(app);
#ifdef LIMBER_WITH_SMOOTHER
  limber::app::add_smooth_command(app);
#endif
  limber::app::add_health_command(app);
  limber::app::add_simulate_command(app);
  limber::app::add_evaluate_command(app);
  limber::app::add_study_command(app);
  limber::app::add_paper_command(app);
  limber::app::add_report_command(app);
  return run(app, argc, argv);
}
