// SPDX-License-Identifier: MIT
// limber report: results become a page.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "replaceable.hpp"
#include "report_files.hpp"

namespace limber::app {
namespace {

struct ReportArguments {
  std::filesystem::path results, out;
  bool force = false;
};

void report(const ReportArguments& arguments) {
  const std::filesystem::path page =
      arguments.out.empty() ? default_report_path(arguments.results) : arguments.out;
  if (arguments.out.empty()) {
    require_remakable(page, kPageMark, arguments.results, arguments.force);
  } else {
    require_replaceable(page, kPageMark, arguments.force, {arguments.results});
  }
  make_report(arguments.results, page);
  fmt::print("{}\n", page.string());
}

}  // namespace

void add_report_command(CLI::App& app) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand("report", "Draw results as one HTML file that needs no network");
  command->add_option("RESULTS", arguments->results, "Folder of a run, or database of a study")->required();
  command->add_option("--out", arguments->out,
                      "File to write; default: report.html in the folder, or study.html beside study.sqlite");
  add_force_option(*command, arguments->force);
  command->footer(
      "\nPrints the name of the file. Made anew from the results as they are, also of a study that still "
      "runs;\nonly what --out names has to be new, unless --force is given.\nExample:\n  limber report "
      "runs/v101 --out v101.html");
  command->callback([arguments] { report(*arguments); });
}

}  // namespace limber::app
