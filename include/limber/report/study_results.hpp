// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "limber/study/study_database.hpp"
#include "limber/study/study_table.hpp"

/// All that a report draws of a study, in memory.
namespace limber {

/// A method with its runs and mean curves.
struct StudyMethodResults {
  /// which method, and what is varied of it
  MethodVariant variant;
  /// what the tables say of it
  MethodSummary summary;
  std::vector<StudyRun> runs;                  ///< finished ones
  std::map<CurveQuantity, StudyCurve> curves;  ///< those that are defined for the method
};

/// A case with the results of its methods.
struct StudyCaseResults {
  /// scenario, runs and methods
  StudyCaseInfo info;
  std::vector<StudyMethodResults> methods;  ///< in the order of info.methods
  /// paths of run 0
  ExampleRun example;
};

/// All cases of a study.
struct StudyResults {
  /// that began the study
  std::string program_version;
  /// of everything random
  std::uint64_t seed = 0;
  /// in the order of the plan
  std::vector<StudyCaseResults> cases;
};

/// @throws DataError if the file is no study that this version can read
[[nodiscard]] StudyResults load_study(const std::filesystem::path& database);

}  // namespace limber
