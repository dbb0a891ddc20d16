// SPDX-License-Identifier: MIT
// limber study: Monte Carlo over scenarios, methods and runs.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "commands.hpp"
#include "limber/study/exact_sum.hpp"
#include "limber/study/merge_studies.hpp"
#include "limber/study/study_table.hpp"
#include "messages.hpp"
#include "parsed_by.hpp"
#include "recording_options.hpp"
#include "replaceable.hpp"
#include "report_files.hpp"
#include "scenario_options.hpp"
#include "study_runner.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

struct StudyArguments {
  std::vector<fs::path> scenarios;
  std::string methods = "ekf,ekf-full,lcekf";
  std::string start{name_of(StartMode::kAuto)};
  std::uint64_t runs = 100, seed = 1;
  fs::path out;
  bool brief = false;
  ScenarioArguments changes;
  RunnerArguments runner;
};

StudyPlan plan_of(const StudyArguments& arguments) {
  StudyPlan plan;
  plan.seed = arguments.seed;
  for (const fs::path& path : arguments.scenarios) {
    plan.cases.push_back({read_scenario(path, arguments.changes),
                          method_variants_from_string(arguments.methods), arguments.runs,
                          start_mode_from_string(arguments.start)});
  }
  return plan;
}

void print_tables(const fs::path& path, bool brief) {
  const StudyDatabase database(path);
  fmt::print("{}", brief ? format_brief_table(database) : format_study_table(database));
}

void add_brief_option(CLI::App& command, bool& brief) {
  command.add_flag("--brief", brief, "Print one table of the main figures instead of one per scenario");
}

void study(const StudyArguments& arguments) {
  StudyRanks ranks;
  if (ranks.rank() > 0) {
    ranks.serve(arguments.runner.threads);
    return;
  }
  const bool complete = run_with_progress(plan_of(arguments), arguments.out, arguments.runner, ranks);
  print_tables(arguments.out, arguments.brief);
  export_study(arguments.out, arguments.runner.export_format);
  make_report_beside(arguments.out);
  if (!complete) {
    throw CLI::RuntimeError(kExitFailed);
  }
}

void add_merge_command(CLI::App& study_command) {
  struct Arguments {
    std::vector<fs::path> parts;
    fs::path out;
    bool force = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = study_command.add_subcommand("merge", "Make one study from its shards");
  command->add_option("PART", arguments->parts, "Databases made with --shard")->required();
  command->add_option("--out", arguments->out, "The database to make")->required();
  add_force_option(*command, arguments->force);
  command->footer("\nExample:\n  limber study merge part1.sqlite part2.sqlite --out study.sqlite");
  command->callback([arguments] {
    require_replaceable_page(arguments->out, arguments->force);
    merge_studies(arguments->parts, arguments->out);
    fmt::print("{}", format_study_table(StudyDatabase(arguments->out)));
    make_report_beside(arguments->out);
  });
}

void add_show_command(CLI::App& study_command) {
  struct Arguments {
    fs::path database;
    std::string format;
    bool brief = false, force = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = study_command.add_subcommand("show", "Print the tables of a study, finished or not");
  command->add_option("DATABASE", arguments->database, "What --out named")->required();
  add_brief_option(*command, arguments->brief);
  command
      ->add_option("--export", arguments->format, "Also write the results beside the database: csv or json")
      ->transform(one_of({"csv", "json"}));
  add_force_option(*command, arguments->force);
  command->footer("\nExample:\n  limber study show study.sqlite --export csv");
  command->callback([arguments] {
    require_replaceable_export(arguments->database, arguments->format, arguments->force);
    print_tables(arguments->database, arguments->brief);
    export_study(arguments->database, arguments->format);
  });
}

}  // namespace

void add_study_command(CLI::App& app) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* command = app.add_subcommand("study", "Monte Carlo: scenarios x methods x runs, resumable");
  CLI::Option* scenarios =
      command->add_option("SCENARIO", arguments->scenarios, "Scenario files (YAML), see scenarios/README.md");
  CLI::Option* out =
      command->add_option("--out", arguments->out, "Database (SQLite) that is made or gone on with");
  command
      ->add_option(
          "--methods", arguments->methods,
          "Comma-separated: ekf, ekf-full, lcekf, soft, consider, adaptive, mono-left, oracle, each with "
          "options: "
          "lcekf:rotation+direction, lcekf:ax,tx, ekf:cartesian, ekf-full:walk=x10, ekf-full:walk=1e-6/1")
      ->check(parsed_by(method_variants_from_string))
      ->capture_default_str();
  add_start_option(*command, arguments->start);
  command->add_option("--runs", arguments->runs, "Of each method in each scenario")
      ->check(CLI::Range(std::uint64_t{1}, kMaxTerms))
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "Of everything random")->capture_default_str();
  add_brief_option(*command, arguments->brief);
  add_scenario_options(*command, arguments->changes);
  add_runner_options(*command, arguments->runner);
  add_merge_command(*command);
  add_show_command(*command);
  command->require_subcommand(0, 1);
  command->footer(
      "\nAll methods see the same noise in a run. Killed at any moment, the same command goes on; more runs "
      "and\n"
      "scenarios may be added later. With several processes: mpirun -n 4 limber study ... The results are "
      "the same,\n"
      "bit for bit, for any number of threads, processes, shards and interruptions. docs/study-database.md "
      "says "
      "more.\n"
      "Example:\n"
      "  limber study scenarios/paper_i.yaml scenarios/paper_ii.yaml --methods ekf,lcekf --runs 20 --out "
      "study.sqlite");
  command->callback([arguments, command, scenarios, out] {
    if (!command->get_subcommands().empty()) {
      return;
    }
    for (const CLI::Option* option : {scenarios, out}) {
      if (option->empty()) {
        throw CLI::RequiredError(option->get_name());
      }
    }
    study(*arguments);
  });
}

}  // namespace limber::app
