// SPDX-License-Identifier: MIT
// limber compare: runs beside each other.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "comparison_text.hpp"
#include "limber/report/compare_report.hpp"
#include "limber/report/write_report.hpp"
#include "messages.hpp"
#include "replaceable.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

struct CompareArguments {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path out;
  CompareOptions options;
  bool json = false, force = false;
};

void compare(const CompareArguments& arguments) {
  const std::vector<std::filesystem::path> folders = run_folders(arguments.runs);
  if (folders.size() < 2) {
    throw CLI::ValidationError("RUN",
                               "expected two runs at least, found " + folders.front().string() + " alone");
  }
  if (!arguments.out.empty()) {
    require_replaceable(arguments.out, kPageMark, arguments.force, folders);
  }
  const RunComparison comparison = compare_runs(folders, arguments.options);
  if (!arguments.out.empty()) {
    write_report(compare_report(folders, arguments.options), arguments.out);
  }
  fmt::print("{}", arguments.json ? to_json(comparison) : to_text(comparison));
  if (!arguments.out.empty()) {
    print_note("written: " + arguments.out.string());
  }
}

}  // namespace

void add_compare_command(CLI::App& app) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command =
      app.add_subcommand("compare", "Compare runs: a table, differences with intervals, a page");
  command
      ->add_option(
          "RUN", arguments->runs,
          "Folder of a run, or a folder of such folders; the others are compared with the first one of "
          "their recording")
      ->required()
      ->check(not_empty());
  command->add_option("--out", arguments->out, "Draw a page, too: one HTML file that needs no network")
      ->check(not_empty());
  command->add_flag("--json", arguments->json, "Print JSON instead of tables");
  command
      ->add_option(
          "--piece", arguments->options.piece_m,
          "Length of the pieces that relative errors are of [m]; default: a round length of which ten "
          "or more fit into the path")
      ->check(positive());
  command->add_flag(
      "--across-assumptions", arguments->options.across_assumptions,
      "Pair runs that assume different things of their recording (calibration, noise, start), too");
  add_force_option(*command, arguments->force);
  command->footer(
      "\nErrors are paired piece by piece, for runs of the same recording with its truth: the mean "
      "difference "
      "with its\n"
      "95 % interval, and 'cannot tell' where that holds zero. ATE after a rigid fit; RPE: mean over "
      "disjoint "
      "pieces of\n"
      "the path; scale: error of the estimate; apart: distance between two runs.\n"
      "Example:\n  limber compare runs/v101-methods --out comparison.html");
  command->callback([arguments] { compare(*arguments); });
}

}  // namespace limber::app
