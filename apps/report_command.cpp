// SPDX-License-Identifier: MIT
// limber report: results become a page.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "limber/report/run_report.hpp"
#include "limber/report/write_report.hpp"

namespace limber::app {
namespace {

struct ReportArguments {
  std::filesystem::path results, out;
};

void report(const ReportArguments& arguments) {
  const std::filesystem::path out = arguments.out.empty() ? arguments.results / kReportName : arguments.out;
  write_report(run_report(arguments.results), out);
  fmt::print("{}\n", out.string());
}

}  // namespace

void add_report_command(CLI::App& app) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand("report", "Draw results as one HTML file that needs no network");
  command->add_option("RESULTS", arguments->results, "Folder of a run")->required();
  command->add_option("--out", arguments->out,
                      "File to write; default: report.html in the folder of the results");
  command->footer("\nExample:\n  limber report runs/v101 --out v101.html");
  command->callback([arguments] { report(*arguments); });
}

}  // namespace limber::app
