// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "limber/report/study_results.hpp"
#include "report/main_methods.hpp"
#include "reproduce/paper_claims.hpp"

/// The measures that the paper's claims are put to, and what came of them.
namespace limber::detail {

/// "The same": within this factor, either way.
inline constexpr double kSame = 1.25;
/// Instants "at the start" and "at the end" of landmarks [s].
inline constexpr double kStart = 1.0;
inline constexpr double kEnd = 1.0;

/// A measurement in words, and whether the claim holds; no value where it could not be measured.
struct Outcome {
  std::string measured;
  std::optional<bool> holds;
};

/// All of them, a line each: false if one is false, else not known if one is not known.
[[nodiscard]] Outcome all_of(const std::vector<Outcome>& outcomes);

/// One method in one case.
struct Measured {
  const StudyCaseResults* study_case = nullptr;
  const StudyMethodResults* method = nullptr;

  [[nodiscard]] const std::string& label() const { return method->summary.label; }
  [[nodiscard]] const StudyCurve* curve(CurveQuantity quantity) const;
};

/// A study with the paper's name of each of its cases. The results must outlive it.
struct PaperStudy {
  explicit PaperStudy(const StudyResults& study);

  const StudyResults& results;
  std::vector<std::optional<PaperCase>> cases;
};

/// The case of a study that is this case of the paper and has its three methods, the one with most runs if
/// there are several; nullptr if there is none with a finished run.
[[nodiscard]] const StudyCaseResults* find_case(const PaperStudy& study, const PaperCase& paper_case);

/// The paper's method in a case. Nothing if it is not there.
[[nodiscard]] std::optional<Measured> find_method(const StudyCaseResults& study_case, MainMethod method);

/// Whether a case has all three of them.
[[nodiscard]] bool has_paper_methods(const StudyCaseResults& study_case);

/// ekf-full with this walk per 10 ms (Table 1) in any sinus case without IMU.
[[nodiscard]] std::optional<Measured> find_walk(const PaperStudy& study, double rotation_rad2,
                                                double translation_mm2);

/// A figure of merit with which methods are compared: infinite if some run diverged.
struct Score {
  double value = 0.0;
  std::string text;  ///< "lcekf 0.041 m", "ekf-full diverged in 3 of 100 runs"
};
[[nodiscard]] std::optional<Score> position_score(const Measured& m);
[[nodiscard]] std::optional<Score> attitude_score(const Measured& m);
/// Root mean square error of the points in the map within kStart of the beginning, or kEnd of the end.
[[nodiscard]] std::optional<Score> landmark_start_score(const Measured& m);
[[nodiscard]] std::optional<Score> landmark_end_score(const Measured& m);

/// a <= factor * b, of the position RMSE.
[[nodiscard]] Outcome position_at_most(const Measured& a, double factor, const Measured& b);
/// Position and attitude RMSE both smaller than those of b.
[[nodiscard]] Outcome better(const Measured& a, const Measured& b);
/// Position and attitude RMSE within the factor kSame of each other.
[[nodiscard]] Outcome same_localization(const Measured& a, const Measured& b);
/// Position RMSE of all within the factor.
[[nodiscard]] Outcome same_position(const std::vector<Measured>& all, double factor = kSame);
[[nodiscard]] Outcome landmarks_start_better(const Measured& a, const Measured& b);
[[nodiscard]] Outcome landmarks_end_the_same(const Measured& a, const Measured& b);

/// The paper's word for curves that leave the plot: a run diverged, or the mean squared position error lies
/// above its 3 sigma (9 times the mean variance) at more than half of the instants.
[[nodiscard]] Outcome diverges(const Measured& m);
[[nodiscard]] Outcome does_not_diverge(const Measured& m);
/// The mean squared position error of the last quarter is above that of the first.
[[nodiscard]] Outcome drifts(const Measured& m);
/// The Sim(3) scale departs from 1 by at most 2 %, root mean square over runs.
[[nodiscard]] Outcome keeps_scale(const Measured& m);

/// Median time per frame of a at most `factor` times that of b.
[[nodiscard]] Outcome time_at_most(const Measured& a, double factor, const Measured& b);

}  // namespace limber::detail
