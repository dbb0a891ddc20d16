// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "limber/study/study_plan.hpp"

/// The experiment of [Vivet2022], section 4, as a study.
namespace limber {

/// A figure of the paper.
struct PaperFigure {
  int number = 0;                  ///< 3 to 18
  std::string title;               ///< e.g. "(ii) constant error, IMU"
  std::vector<std::string> cases;  ///< the shipped scenarios that it draws, by name
  std::uint64_t runs = 0;          ///< of each, in the paper
};

/// All figures with results, by number. Table 1 is that of Figures 15 to 18.
[[nodiscard]] const std::vector<PaperFigure>& paper_figures();

struct PaperOptions {
  std::vector<int> figures;           ///< empty: all
  std::optional<std::uint64_t> runs;  ///< at most that many of each case, instead of the paper's 100 and 10
  /// Beside the paper's ekf, ekf-full and lcekf: mono-left, oracle and constraint sets in every case, and
  /// ekf-full with other walks in cases of their own (NAME_walks, at most 10 runs).
  bool beyond = true;
  std::uint64_t seed = 1;
};

/// @brief What has to be computed for some figures: every case once, with as many runs as the figure that
/// needs most.
/// @throws std::invalid_argument for a figure that does not exist; the message names those that do
[[nodiscard]] StudyPlan paper_plan(const PaperOptions& options);

/// The figures that show a case, e.g. "Figures 5 and 11"; nothing for a case that none shows.
[[nodiscard]] std::string paper_figures_of(const std::string& study_case);

}  // namespace limber
