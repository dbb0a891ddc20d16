// SPDX-License-Identifier: MIT
#include "run_methods.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <deque>
#include <map>
#include <stdexcept>
#include <utility>

#include "commands.hpp"
#include "comparison_text.hpp"
#include "grouped_texts.hpp"
#include "interrupt.hpp"
#include "limber/core/errors.hpp"
#include "limber/navigate/method.hpp"
#include "limber/report/compare_report.hpp"
#include "limber/report/write_report.hpp"
#include "messages.hpp"
#include "output_folder.hpp"
#include "replaceable.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

/// What became of the methods.
struct Outcome {
  std::vector<fs::path> folders;  ///< of what was written
  std::map<std::string, std::vector<std::string>> notes;
  std::map<std::string, std::vector<std::string>> failures;
  bool all_done = true;
};

void run_one(const std::string& method, const fs::path& folder, const RunOneMethod& run, Outcome& out) {
  std::vector<std::string> notes;
  try {
    run(method, folder, notes);
    out.folders.push_back(folder);
  } catch (const CLI::RuntimeError&) {
    out.folders.push_back(folder);
    out.all_done = false;
  } catch (const CLI::Error&) {  // wrong for every method
    throw;
  } catch (const DataError&) {
    throw;
  } catch (const std::exception& error) {
    out.all_done = false;
    if (!Interrupt::asked()) {
      out.failures[method] = {error.what()};
    }
  }
  out.notes[method] = notes;
}

void print_notes(const std::vector<std::string>& methods, const Outcome& outcome) {
  for (const auto& [note, of] : by_text(methods, outcome.notes)) {
    print_note(of.size() == outcome.folders.size() ? note : fmt::format("{}: {}", fmt::join(of, ", "), note));
  }
}

void print_failures(const std::vector<std::string>& methods, const Outcome& outcome) {
  for (const auto& [why, of] : by_text(methods, outcome.failures)) {
    print_error(why.starts_with(of.front()) ? why : fmt::format("{}: {}", fmt::join(of, ", "), why));
  }
}

void draw_page(const std::vector<fs::path>& folders, const fs::path& page) {
  if (!can_write_reports()) {
    print_note("the page is left out: " + why_no_reports());
    return;
  }
  write_report(compare_report(folders), page);
  print_note("written: " + page.string());
}

}  // namespace

std::vector<std::string> different_methods(const std::vector<std::string>& names) {
  std::vector<std::string> methods;
  for (const std::string& name : names) {
    const std::string method = to_string(method_from_string(name));
    if (std::find(methods.begin(), methods.end(), method) != methods.end()) {
      throw CLI::ValidationError("--methods", method + " is named twice");
    }
    methods.push_back(method);
  }
  return methods;
}

void run_methods(const std::vector<std::string>& methods, const fs::path& out, bool force,
                 const RunOneMethod& run) {
  require_no_recording(out);
  std::deque<ClaimedFolder> claimed;
  for (const std::string& method : methods) {
    require_replaceable_run(out / method, force);
    claimed.emplace_back(out / method);
  }
  require_replaceable(out / kComparisonPage, kPageMark, force);
  claimed.emplace_back(out);
  const Interrupt interrupt;
  Outcome outcome;
  std::vector<std::string> left = methods;
  while (!left.empty() && !Interrupt::asked()) {
    run_one(left.front(), out / left.front(), run, outcome);
    left.erase(left.begin());
  }
  print_notes(methods, outcome);
  if (!outcome.folders.empty()) {
    fmt::print("{}", to_text(compare_runs(outcome.folders)));
    draw_page(outcome.folders, out / kComparisonPage);
  }
  print_failures(methods, outcome);
  if (!left.empty()) {
    print_note(fmt::format("stopped: not run: {}", fmt::join(left, ", ")));
  }
  if (!outcome.all_done || !left.empty()) {
    throw CLI::RuntimeError(kExitFailed);
  }
}

}  // namespace limber::app
