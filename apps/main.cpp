// SPDX-License-Identifier: MIT
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include "commands.hpp"
#include "messages.hpp"

namespace {

using limber::app::print_error;
using limber::app::print_note;

// What was wrong with the command line, and what to type next.
int report_usage(const CLI::App& app, const CLI::ParseError& error) {
  const auto chosen = app.get_subcommands();
  std::string commands;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    commands += (commands.empty() ? "" : ", ") + command->get_name();
  }
  // CLI11 complains of the missing command before it looks at what stands in its place.
  const auto unexpected = app.remaining();
  print_error(chosen.empty() && !unexpected.empty() ? "unknown: " + unexpected.front() : error.what());
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
  } catch (const std::exception& error) {
    print_error(error.what());
    return limber::app::kExitFailed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"limber: stereo navigation for rigs that bend", "limber"};
  app.set_version_flag("--version", "limber " LIMBER_VERSION, "Print the version and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.require_subcommand(1);
  app.footer(
      "\nExit codes: 0 done, 1 failed, 2 wrong usage. Messages go to stderr, results to stdout.\n"
      "Example:\n  limber evaluate runs/v101/trajectory.csv data/v101");
  limber::app::add_run_command(app);
  limber::app::add_simulate_command(app);
  limber::app::add_evaluate_command(app);
  limber::app::add_study_command(app);
  limber::app::add_paper_command(app);
  return run(app, argc, argv);
}
