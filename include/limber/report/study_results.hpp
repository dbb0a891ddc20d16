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
  MethodVariant variant;
  MethodSummary summary;
  std::vector<StudyRun> runs;                  ///< finished ones
  std::map<CurveQuantity, StudyCurve> curves;  ///< those that are defined for the method
};

/// A case with the results of its methods.
struct StudyCaseResults {
  StudyCaseInfo info;
  std::vector<StudyMethodResults> methods;  ///< in the order of info.methods
  ExampleRun example;
};

/// All cases of a study.
struct StudyResults {
  std::string program_version;
  std::uint64_t seed = 0;
  std::vector<StudyCaseResults> cases;
};

/// @throws DataError if the file is no study that this version can read
[[nodiscard]] StudyResults load_study(const std::filesystem::path& database);

}  // namespace limber
