// SPDX-License-Identifier: MIT
// limber paper: the experiment of the paper.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "limber/study/exact_sum.hpp"
#include "limber/study/study_table.hpp"
#include "output_folder.hpp"
#include "report_files.hpp"
#include "reproduce/paper_plan.hpp"
#include "study_runner.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

struct PaperArguments {
  fs::path out;
  std::vector<int> figures;
  std::optional<std::uint64_t> runs;
  std::uint64_t seed = 1;
  bool three_methods = false;
  RunnerArguments runner;
};

StudyPlan plan_of(const PaperArguments& arguments) {
  return paper_plan({arguments.figures, arguments.runs, !arguments.three_methods, arguments.seed});
}

void print_tables(const StudyDatabase& study, const StudyPlan& plan) {
  for (std::size_t k = 0; k < study.info().cases.size(); ++k) {
    const StudyCaseInfo& info = study.info().cases[k];
    const bool asked = std::any_of(plan.cases.begin(), plan.cases.end(),
                                   [&](const StudyCase& c) { return c.scenario.name == info.name; });
    if (asked) {
      const std::string figures = paper_figures_of(info.name);
      fmt::print("{}{}{}: {} of {} runs, started {}\n\n{}\n", figures, figures.empty() ? "" : ", ", info.name,
                 info.finished, info.runs, start_in_words(info.start), format_case_table(study, k));
    }
  }
}

void paper(const PaperArguments& arguments) {
  StudyRanks ranks;
  if (ranks.rank() > 0) {
    ranks.serve(arguments.runner.threads);
    return;
  }
  const StudyPlan plan = plan_of(arguments);
  require_writable_folder(arguments.out);
  fs::create_directories(arguments.out);
  const fs::path database = arguments.out / "paper.sqlite";
  const bool complete = run_with_progress(plan, database, arguments.runner, ranks);
  print_tables(StudyDatabase(database), plan);
  export_study(database, arguments.runner.export_format);
  make_report_beside(database);
  if (!complete) {
    throw CLI::RuntimeError(kExitFailed);
  }
}

CLI::Validator known_figure() {
  return {[](std::string& text) {
            try {
              (void)paper_plan({{std::stoi(text)}, 1, false, 1});
              return std::string();
            } catch (const std::exception&) {
              return "expected a figure with results, 3 to 18, found '" + text + "'";
            }
          },
          ""};
}

}  // namespace

void add_paper_command(CLI::App& app) {
  auto arguments = std::make_shared<PaperArguments>();
  CLI::App* command =
      app.add_subcommand("paper", "The paper's whole experiment: figures 3 to 18 and table 1");
  command
      ->add_option("--out", arguments->out, "Folder for paper.sqlite, made or gone on with, and paper.html")
      ->required();
  command->add_option("--figure", arguments->figures, "Only this one; may be given several times")
      ->check(known_figure());
  command
      ->add_option("--runs", arguments->runs,
                   "At most that many runs of each case, instead of the paper's 100 and 10")
      ->check(CLI::Range(std::uint64_t{1}, kMaxTerms));
  command->add_option("--seed", arguments->seed, "Of everything random")->capture_default_str();
  command->add_flag(
      "--three-methods", arguments->three_methods,
      "Only the paper's ekf, ekf-full and lcekf: no mono-left, oracle, constraint sets and walks");
  add_runner_options(*command, arguments->runner);
  command->footer(
      "\nThe scenarios are those of scenarios/paper_*.yaml. Killed at any moment, the same command goes on. "
      "As\n"
      "limber study it shares the work among threads, the processes of mpirun, or shards.\n"
      "Example:\n  limber paper --runs 5 --figure 6 --figure 10 --out results/paper");
  command->callback([arguments] { paper(*arguments); });
}

}  // namespace limber::app
