// SPDX-License-Identifier: MIT
#include "reproduce/paper_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "limber/simulate/scenario_file.hpp"
#include "reproduce/paper_scenarios.hpp"

namespace limber {
namespace {

constexpr std::uint64_t kManyRuns = 100;  // Figures 5 to 10
constexpr std::uint64_t kFewRuns = 10;    // Figures 11 to 18

// Without IMU the default of lcekf keeps the baseline's length; the paper's lcekf constrains all six.
constexpr const char* kPaperMethods = "ekf,ekf-full,lcekf:full";
constexpr const char* kBeyondMethods = "lcekf:rotation+direction,lcekf:rotation,mono-left,oracle";
// Table 1: none, underestimated and overestimated; well estimated is what the scenarios say.
constexpr const char* kTable1 = "ekf-full:walk=0/0,ekf-full:walk=0.5e-6/0.1,ekf-full:walk=2e-5/20";
constexpr const char* kTable1Case = "paper_iii_vision";
// So that ekf-full does not lose for want of tuning.
constexpr const char* kWalkVariants =
    "ekf-full:walk=x0.001,ekf-full:walk=x0.01,ekf-full:walk=x0.1,ekf-full:walk=x10,ekf-full:walk=x100,"
    "ekf-full:walk=x1000";

bool has_walks(const std::string& name) { return !name.ends_with("_vision"); }

Scenario scenario_of(const std::string& name) {
  return parse_scenario(detail::paper_scenario_text(name), name + ".yaml");
}

StudyCase case_of(const std::string& name, std::uint64_t runs, bool beyond) {
  std::string methods = kPaperMethods;
  if (name == kTable1Case) {
    methods += std::string(",") + kTable1;
  }
  if (beyond) {
    methods += std::string(",") + kBeyondMethods;
  }
  return {scenario_of(name), method_variants_from_string(methods), runs, StartMode::kGroundTruth};
}

StudyCase walks_of(const std::string& name, std::uint64_t runs) {
  StudyCase out{scenario_of(name), method_variants_from_string(kWalkVariants), std::min(runs, kFewRuns),
                StartMode::kGroundTruth};
  out.scenario.name += "_walks";
  return out;
}

const PaperFigure& figure_of(int number) {
  std::string known;
  for (const PaperFigure& figure : paper_figures()) {
    if (figure.number == number) {
      return figure;
    }
    known += (known.empty() ? "" : ", ") + std::to_string(figure.number);
  }
  throw std::invalid_argument(
      fmt::format("the paper has no figure {} with results, expected one of {}", number, known));
}

std::vector<PaperFigure> chosen_figures(const std::vector<int>& numbers) {
  if (numbers.empty()) {
    return paper_figures();
  }
  std::vector<PaperFigure> out;
  for (const int number : numbers) {
    out.push_back(figure_of(number));
  }
  return out;
}

/// Cases in the order in which figures first need them, with the largest number of runs.
std::vector<std::pair<std::string, std::uint64_t>> cases_for(const std::vector<PaperFigure>& figures) {
  std::vector<std::pair<std::string, std::uint64_t>> out;
  for (const PaperFigure& figure : figures) {
    for (const std::string& name : figure.cases) {
      const auto found =
          std::find_if(out.begin(), out.end(), [&](const auto& entry) { return entry.first == name; });
      if (found == out.end()) {
        out.emplace_back(name, figure.runs);
      } else {
        found->second = std::max(found->second, figure.runs);
      }
    }
  }
  return out;
}

}  // namespace

const std::vector<PaperFigure>& paper_figures() {
  static const std::vector<PaperFigure> kFigures = {
      {3, "trajectory and points", {"paper_i"}, 1},
      {4,
       "errors of the calibration",
       {"paper_i", "paper_ii", "paper_iii", "paper_iv", "paper_v", "paper_v_strong"},
       1},
      {5, "(i) no error, IMU", {"paper_i"}, kManyRuns},
      {6, "(ii) constant error, IMU", {"paper_ii"}, kManyRuns},
      {7, "(iii) sinus, IMU", {"paper_iii"}, kManyRuns},
      {8, "(iv) steps, IMU", {"paper_iv"}, kManyRuns},
      {9, "(v) square wave, IMU", {"paper_v"}, kManyRuns},
      {10, "(v) square wave with 0.5 m on the baseline, IMU", {"paper_v_strong"}, kManyRuns},
      {11, "(i) with and without IMU", {"paper_i", "paper_i_vision"}, kFewRuns},
      {12, "(ii) with and without IMU", {"paper_ii", "paper_ii_vision"}, kFewRuns},
      // The caption says 'chock (iii)', the text (i) to (v): both are drawn.
      {13,
       "(iii) and (iv) with and without IMU",
       {"paper_iii", "paper_iii_vision", "paper_iv", "paper_iv_vision"},
       kFewRuns},
      {14, "(v) with and without IMU", {"paper_v", "paper_v_vision"}, kFewRuns},
      {15, "(iii) without IMU, walk of theta well estimated", {kTable1Case}, kFewRuns},
      {16, "(iii) without IMU, no walk of theta", {kTable1Case}, kFewRuns},
      {17, "(iii) without IMU, walk of theta underestimated", {kTable1Case}, kFewRuns},
      {18, "(iii) without IMU, walk of theta overestimated", {kTable1Case}, kFewRuns},
  };
  return kFigures;
}

StudyPlan paper_plan(const PaperOptions& options) {
  StudyPlan plan;
  plan.seed = options.seed;
  for (const auto& [name, paper_runs] : cases_for(chosen_figures(options.figures))) {
    const std::uint64_t runs = std::min(paper_runs, options.runs.value_or(paper_runs));
    plan.cases.push_back(case_of(name, runs, options.beyond));
    if (options.beyond && has_walks(name)) {
      plan.cases.push_back(walks_of(name, runs));
    }
  }
  return plan;
}

std::string paper_figures_of(const std::string& study_case) {
  std::vector<int> numbers;
  for (const PaperFigure& figure : paper_figures()) {
    const auto& cases = figure.cases;
    if (figure.runs > 1 && std::find(cases.begin(), cases.end(), study_case) != cases.end()) {
      numbers.push_back(figure.number);
    }
  }
  std::string text;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const std::string_view before = k == 0 ? "" : k + 1 == numbers.size() ? " and " : ", ";
    text += fmt::format("{}{}", before, numbers[k]);
  }
  return text.empty() ? text : (numbers.size() > 1 ? "Figures " : "Figure ") + text;
}

}  // namespace limber
