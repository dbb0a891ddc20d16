// SPDX-License-Identifier: MIT
#include "study_runner.hpp"

#include <fmt/format.h>

#include <chrono>

#include "interrupt.hpp"
#include "limber/study/export_study.hpp"
#include "messages.hpp"
#include "parsed_by.hpp"
#include "progress.hpp"
#include "replaceable.hpp"
#include "validators.hpp"

namespace limber::app {
namespace {

constexpr std::size_t kBarSteps = 1000;

std::string describe(const StudyProgress& progress, double seconds) {
  std::string text = fmt::format("{} of {} runs", progress.runs, progress.total);
  if (progress.now > 0) {
    text += fmt::format(", {:.2g} runs/s", static_cast<double>(progress.now) / seconds);
  }
  return text;
}

}  // namespace

void add_runner_options(CLI::App& command, RunnerArguments& arguments) {
  command
      .add_option("--threads", arguments.threads,
                  "Runs at a time in each process; 0: one per core, or one each if mpirun started several")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  command
      .add_option("--shard", arguments.shard,
                  "INDEX/COUNT: only this part, for job arrays; see limber study merge")
      ->check(parsed_by(shard_from_string))
      ->capture_default_str();
  command
      .add_option("--export", arguments.export_format,
                  "Also write the results beside the database: csv or json")
      ->transform(one_of({"csv", "json"}));
  add_force_option(command, arguments.force);
}

bool run_with_progress(const StudyPlan& plan, const std::filesystem::path& database,
                       const RunnerArguments& arguments, StudyRanks& ranks) {
  require_replaceable_page(database, arguments.force);
  require_replaceable_export(database, arguments.export_format, arguments.force);
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  StudyOutcome outcome;
  {
    const Interrupt interrupt;
    Progress bar(database.filename().string(), kBarSteps);
    StudyOptions options;
    options.threads = arguments.threads;
    options.shard = shard_from_string(arguments.shard);
    options.stop = Interrupt::asked;
    options.progress = [&](const StudyProgress& progress) {
      bar.done(static_cast<std::size_t>(progress.share * static_cast<double>(kBarSteps)),
               describe(progress, seconds()));
    };
    outcome = run_study(plan, database, options, &ranks);
  }
  const StudyProgress& progress = outcome.progress;
  print_note(fmt::format("{}: {} runs, {} of them now, in {:.1f} s", database.string(), progress.runs,
                         progress.now, seconds()));
  if (outcome.stopped) {
    print_note(fmt::format("stopped with {} of {} runs; the same command goes on from there", progress.runs,
                           progress.total));
  }
  return !outcome.stopped;
}

void export_study(const std::filesystem::path& database, const std::string& format) {
  if (format.empty()) {
    return;
  }
  const StudyDatabase study(database);
  for (const auto& file : format == "csv" ? export_csv(study, database) : export_json(study, database)) {
    print_note("written: " + file.string());
  }
}

}  // namespace limber::app
