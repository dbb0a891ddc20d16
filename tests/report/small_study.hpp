// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "limber/report/study_results.hpp"
#include "limber/simulate/scenario_file.hpp"

/// Results of studies that never ran, with numbers of the test's own.
namespace limber::testing {

/// The rig is bent as in case (ii) of the paper.
inline Scenario bent_scenario() {
  Scenario scenario;
  scenario.name = "bent";
  scenario.decalibration = {{paper_decalibration(), ConstantShape{}}};
  return scenario;
}

/// What a method got in each of its 10 runs.
struct Got {
  std::string label;
  double position = 0.1;         ///< RMSE [m]; constant over time
  double attitude = 0.1;         ///< [deg]
  double sigma = 0.1;            ///< that the filter claims [m]
  double landmarks_start = 1.0;  ///< RMSE in the first half [m]
  double landmarks_end = 0.1;    ///< in the second
  std::uint64_t diverged = 0;    ///< runs
  double scale = 1.0, ms = 1.0, anees = 1.0;
};

inline constexpr std::size_t kInstants = 41;

inline StudyCurve constant_curve(double value) {
  return {std::vector<double>(kInstants, value), std::vector<std::uint64_t>(kInstants, 10)};
}

inline StudyMethodResults method_results(const Got& got) {
  StudyMethodResults out;
  out.variant = method_variant_from_string(got.label);
  MethodSummary& s = out.summary;
  s.label = got.label;
  s.runs = 10;
  s.diverged = got.diverged;
  if (got.diverged < s.runs) {
    s.position_rmse_m = got.position;
    s.attitude_rmse_deg = got.attitude;
    s.landmark_rmse_m = got.landmarks_end;
    s.anees = got.anees;
    s.position_rmse_median_m = MedianInterval{got.position, 0.9 * got.position, 1.1 * got.position};
    s.anees_median = MedianInterval{got.anees, 0.9 * got.anees, 1.1 * got.anees};
    s.anees_interval = Interval{0.8, 1.2};
  }
  for (std::uint64_t run = 0; run < s.runs; ++run) {
    StudyRun& r = out.runs.emplace_back();
    r.run = run;
    if (run < got.diverged) {
      r.diverged = Divergence{3, 0.15, "lost"};
    } else {
      r.figures.scale = got.scale;
      r.figures.ms_per_frame_p50 = got.ms;
    }
  }
  out.curves[CurveQuantity::kPositionSquaredError] = constant_curve(got.position * got.position);
  out.curves[CurveQuantity::kPositionVariance] = constant_curve(got.sigma * got.sigma);
  out.curves[CurveQuantity::kAttitudeSquaredError] = constant_curve(1e-6);
  out.curves[CurveQuantity::kAttitudeVariance] = constant_curve(1e-6);
  out.curves[CurveQuantity::kPoseNees] = constant_curve(6.0);
  StudyCurve landmarks = constant_curve(got.landmarks_end * got.landmarks_end);
  std::fill_n(landmarks.mean.begin(), kInstants / 2, got.landmarks_start * got.landmarks_start);
  out.curves[CurveQuantity::kLandmarkSquaredError] = landmarks;
  return out;
}

inline StudyCaseResults case_results(Scenario scenario, const std::vector<Got>& methods) {
  StudyCaseResults out;
  scenario.duration = 2.0;
  out.info.name = scenario.name;
  out.info.scenario = scenario;
  out.info.start = StartMode::kGroundTruth;
  out.info.scenario_text = format_scenario(scenario);
  out.info.runs = out.info.finished = 10;
  for (std::size_t k = 0; k < kInstants; ++k) {
    out.info.frame_times.push_back(0.05 * static_cast<double>(k));
  }
  for (const Got& got : methods) {
    out.methods.push_back(method_results(got));
    out.info.methods.push_back(out.methods.back().variant);
    out.info.labels.push_back(got.label);
  }
  return out;
}

inline StudyResults study_of(std::vector<StudyCaseResults> cases) { return {"0.0", 1, std::move(cases)}; }

}  // namespace limber::testing
