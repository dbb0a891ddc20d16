// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "limber/run/run_options.hpp"
#include "limber/simulate/scenario.hpp"
#include "limber/study/method_variant.hpp"

/// What a study computes: cases (a scenario and the methods that run on it), each `runs` times.
namespace limber {

/// A scenario, the methods that run on it, and where they start from.
struct StudyCase {
  /// what is simulated
  Scenario scenario;
  std::vector<MethodVariant> methods;  ///< every one sees the same recording of a run
  std::uint64_t runs = 0;              ///< numbered from 0
  StartMode start = StartMode::kAuto;  ///< of every method
};

/// All cases of a study, and the seed of everything random.
struct StudyPlan {
  /// of everything random
  std::uint64_t seed = 1;
  std::vector<StudyCase> cases;  ///< scenarios with different names
};

/// @throws std::invalid_argument if there is no case, a case has no method or the same one twice, no run or
/// more than kMaxTerms, two scenarios share a name, or check_scenario throws; the message names the case
void check_plan(const StudyPlan& plan);

/// What decides the results of a case, as text: the scenario with every key and its value, the content of a
/// trajectory file in place of its path, and the methods. Two cases with the same text have the same results.
/// @throws DataError if the trajectory file cannot be read
[[nodiscard]] std::string definition_of(const StudyCase& study_case);

/// Times of the stereo frames [s], whether they get lost or not: the x axis of curves.
[[nodiscard]] std::vector<double> frame_times(const Scenario& scenario);

/// How a method runs in a scenario, assuming what scenario.filter says: from the sensors, or from the truth
/// plus an error drawn from scenario.initial.
[[nodiscard]] RunOptions run_options(const Scenario& scenario, const MethodVariant& variant, StartMode start,
                                     std::uint64_t seed, std::uint64_t run);

}  // namespace limber
