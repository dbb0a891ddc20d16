// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "limber/report/document.hpp"
#include "limber/report/study_results.hpp"
#include "limber/simulate/scenario.hpp"

/// What section 4 of [Vivet2022] claims, each claim with a rule that any study's numbers decide.
namespace limber {

/// delta(t) of section 4.2: the cases (i) to (v), and (v) with 0.5 m on the baseline (Figure 10).
enum class PaperNoise : std::uint8_t { kNone, kConstant, kSinus, kSteps, kSquare, kSquareStrong };

struct PaperCase {
  PaperNoise noise = PaperNoise::kNone;
  bool with_imu = true;
  bool operator==(const PaperCase&) const = default;
};

/// "(iv) steps, with IMU".
[[nodiscard]] std::string to_string(const PaperCase& paper_case);

/// @return which case of the paper's experiment a scenario is; nothing if any of its parameters but name,
/// duration, decalibration, IMU, filter and same_world_in_all_runs differ from the paper's
[[nodiscard]] std::optional<PaperCase> paper_case_of(const Scenario& scenario);
/// The same of a case of a study: none unless it starts from the truth, as the paper's runs do.
[[nodiscard]] std::optional<PaperCase> paper_case_of(const StudyCaseInfo& study_case);

struct PaperClaim {
  ReportClaim claim;
  std::vector<PaperCase> cases;  ///< what it speaks of
};

/// All claims, in the paper's order; those that the study cannot decide are kNotMeasured, and say why.
[[nodiscard]] std::vector<PaperClaim> paper_claims(const StudyResults& results);

}  // namespace limber
