// SPDX-License-Identifier: MIT
#include <cmath>
#include <stdexcept>

#include "limber/simulate/scenario_file.hpp"
#include "reproduce/paper_claims.hpp"

namespace limber {
namespace {

constexpr double kStrong = 0.3;  // [m] on the baseline: between the paper's 0.1 m and 0.5 m

/// What a scenario says beside what the paper varies.
std::string common_part(Scenario scenario) {
  const Scenario reference;
  scenario.name = reference.name;
  scenario.duration = reference.duration;
  scenario.use_imu = reference.use_imu;
  scenario.same_world_in_all_runs = reference.same_world_in_all_runs;
  scenario.decalibration = reference.decalibration;
  scenario.filter = reference.filter;
  return format_scenario(scenario);
}

std::optional<PaperNoise> noise_of(const std::vector<DecalibrationSignal>& signals) {
  if (signals.empty()) {
    return PaperNoise::kNone;
  }
  if (signals.size() > 1) {
    return std::nullopt;
  }
  const DecalibrationSignal& signal = signals.front();
  if (std::holds_alternative<ConstantShape>(signal.shape)) {
    return PaperNoise::kConstant;
  }
  if (std::holds_alternative<SinusShape>(signal.shape)) {
    return PaperNoise::kSinus;
  }
  if (std::holds_alternative<StepsShape>(signal.shape)) {
    return PaperNoise::kSteps;
  }
  if (std::holds_alternative<SquareWaveShape>(signal.shape)) {
    return std::abs(signal.amplitude(3)) < kStrong ? PaperNoise::kSquare : PaperNoise::kSquareStrong;
  }
  return std::nullopt;
}

std::string to_string(PaperNoise noise) {
  switch (noise) {
    case PaperNoise::kNone:
      return "(i) none";
    case PaperNoise::kConstant:
      return "(ii) constant";
    case PaperNoise::kSinus:
      return "(iii) sinus";
    case PaperNoise::kSteps:
      return "(iv) steps";
    case PaperNoise::kSquare:
      return "(v) square wave";
    case PaperNoise::kSquareStrong:
      return "(v) square wave, 0.5 m";
  }
  throw std::invalid_argument("to_string: no such noise");
}

}  // namespace

std::string to_string(const PaperCase& paper_case) {
  return to_string(paper_case.noise) + (paper_case.with_imu ? ", with IMU" : ", without IMU");
}

std::optional<PaperCase> paper_case_of(const Scenario& scenario) {
  static const std::string kPaper = common_part(Scenario{});
  const std::optional<PaperNoise> noise = noise_of(scenario.decalibration);
  if (!noise || common_part(scenario) != kPaper) {
    return std::nullopt;
  }
  return PaperCase{*noise, scenario.use_imu};
}

std::optional<PaperCase> paper_case_of(const StudyCaseInfo& study_case) {
  return study_case.start == StartMode::kGroundTruth ? paper_case_of(study_case.scenario) : std::nullopt;
}

}  // namespace limber
