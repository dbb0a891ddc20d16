// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "limber/run/run_options.hpp"
#include "limber/simulate/scenario.hpp"
#include "limber/study/curve.hpp"
#include "limber/study/method_variant.hpp"
#include "limber/study/run_figures.hpp"

namespace limber {

/// One scenario of a study with the methods that ran on it.
struct StudyCaseInfo {
  std::string name;           ///< of the scenario, unique in a study
  Scenario scenario;          ///< parsed from scenario_text
  std::string scenario_text;  ///< every key with its value
  /// in the order of the plan
  std::vector<MethodVariant> methods;
  std::vector<std::string> labels;     ///< to_string of each method
  StartMode start = StartMode::kAuto;  ///< of every method
  std::uint64_t runs = 0;              ///< planned, of each method; runs are numbered from 0
  std::uint64_t finished = 0;          ///< of them, diverged ones included; the same for all methods
  std::vector<double> frame_times;     ///< of the stereo frames, the x axis of every curve [s]
};

/// What a database says of its study.
struct StudyInfo {
  std::string program_version;  ///< of the program that began it
  /// of everything random
  std::uint64_t seed = 0;
  /// in the order of the plan
  std::vector<StudyCaseInfo> cases;
};

/// Run 0 of a case, one point per stereo frame, in the world frame [m].
struct ExampleRun {
  /// positions in the world, one per frame [m]
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> landmarks;  ///< true points that some frame shows
  std::vector<std::vector<Eigen::Vector3d>>
      estimate;  ///< per method; ends where it diverged; empty if not run yet
};

/// @brief Reads the results of a study, also while it is running.
class StudyDatabase {
 public:
  /// @throws DataError if the file is missing, no study, or of another version; the message says which
  explicit StudyDatabase(const std::filesystem::path& path);
  ~StudyDatabase();
  /// The other one may then only be destroyed or assigned to.
  StudyDatabase(StudyDatabase&&) noexcept;
  /// The other one may then only be destroyed or assigned to.
  StudyDatabase& operator=(StudyDatabase&&) noexcept;

  /// What the file says of its study.
  [[nodiscard]] const StudyInfo& info() const;

  /// All finished runs of a method of a case, by number of the run. Indices count in info().
  [[nodiscard]] std::vector<StudyRun> runs(std::size_t study_case, std::size_t method) const;

  /// A curve; nothing where the quantity is not defined for the method (theta of a filter that has none) or
  /// no run is finished.
  [[nodiscard]] std::optional<StudyCurve> curve(std::size_t study_case, std::size_t method,
                                                CurveQuantity quantity) const;

  /// Truth is simulated anew (deterministic), estimates are stored.
  [[nodiscard]] ExampleRun example(std::size_t study_case) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limber
