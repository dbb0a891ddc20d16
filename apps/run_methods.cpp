// SPDX-License-Identifier: MIT
#include "run_methods.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "commands.hpp"
#include "comparison_text.hpp"
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
  std::vector<std::string> failures;  ///< "METHOD failed: why"
  bool all_done = true;
};

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
}

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
      out.failures.push_back(fmt::format("{} failed: {}", method, error.what()));
    }
  }
  out.notes[method] = notes;
}

/// Each note once: with its methods, unless it is of all.
void print_notes(const std::vector<std::string>& methods, const Outcome& outcome) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<std::string>> methods_of;
  for (const std::string& method : methods) {
    for (const std::string& note :
         outcome.notes.contains(method) ? outcome.notes.at(method) : std::vector<std::string>{}) {
      if (methods_of[note].empty()) {
        order.push_back(note);
      }
      methods_of[note].push_back(method);
    }
  }
  for (const std::string& note : order) {
    const bool of_all = methods_of[note].size() == outcome.folders.size();
    print_note(of_all ? note : joined(methods_of[note]) + ": " + note);
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
  for (const std::string& method : methods) {
    require_replaceable_run(out / method, force);
  }
  require_replaceable(out / kComparisonPage, kPageMark, force);
  require_writable_folder(out);
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
  for (const std::string& failure : outcome.failures) {
    print_error(failure);
  }
  if (!left.empty()) {
    print_note("stopped: not run: " + joined(left));
  }
  if (!outcome.all_done || !left.empty()) {
    throw CLI::RuntimeError(kExitFailed);
  }
}

}  // namespace limber::app
