// SPDX-License-Identifier: MIT
#include "limber/study/study_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "definition_text.hpp"
#include "io/text_file.hpp"
#include "limber/core/random.hpp"
#include "limber/io/parameter_text.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"
#include "limber/study/exact_sum.hpp"

namespace limber {
namespace {

constexpr double kStepsPerSecond = 100.0;   // of the paper: a walk is given per 10 ms
constexpr double kSquareMillimetre = 1e-6;  // [m^2]

RigParameters theta_walk(const Scenario& scenario, const std::optional<ThetaWalk>& walk) {
  if (!walk) {
    return scenario.filter.theta_walk;
  }
  if (!walk->absolute) {
    return walk->factor * scenario.filter.theta_walk;
  }
  RigParameters out;
  out.head<3>().setConstant(walk->rotation * kStepsPerSecond);
  out.tail<3>().setConstant(walk->translation * kSquareMillimetre * kStepsPerSecond);
  return out;
}

void check_case(const StudyCase& study_case) {
  const auto fail = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("study: case '{}' {}", study_case.scenario.name, what));
  };
  if (study_case.methods.empty()) {
    fail("has no method");
  }
  if (study_case.runs == 0 || study_case.runs > kMaxTerms) {
    fail(fmt::format("has {} runs, expected 1 to {}", study_case.runs, kMaxTerms));
  }
  std::set<std::string> labels;
  for (const MethodVariant& variant : study_case.methods) {
    if (!labels.insert(to_string(variant)).second) {
      fail(fmt::format("has the method {} twice", to_string(variant)));
    }
  }
  check_scenario(study_case.scenario);
}

}  // namespace

void check_plan(const StudyPlan& plan) {
  if (plan.cases.empty()) {
    throw std::invalid_argument("study: no scenario");
  }
  std::set<std::string> names;
  for (const StudyCase& study_case : plan.cases) {
    check_case(study_case);
    if (!names.insert(study_case.scenario.name).second) {
      throw std::invalid_argument(
          fmt::format("study: two scenarios are called '{}'; give one of them another 'name:'",
                      study_case.scenario.name));
    }
  }
}

std::string detail::definition_text(const std::string& scenario, StartMode start,
                                    const std::vector<std::string>& methods) {
  std::string text = scenario + fmt::format("start: {}\nmethods:\n", name_of(start));
  for (const std::string& method : methods) {
    text += fmt::format("  - {}\n", method);
  }
  return text;
}

std::string definition_of(const StudyCase& study_case) {
  Scenario scenario = study_case.scenario;
  if (auto* trajectory = std::get_if<FileTrajectory>(&scenario.trajectory)) {
    trajectory->path = fmt::format("content-{:016x}", fnv1a(detail::load_text(trajectory->path)));
  }
  std::vector<std::string> methods;
  for (const MethodVariant& variant : study_case.methods) {
    methods.push_back(to_string(variant));
  }
  return detail::definition_text(format_scenario(scenario), study_case.start, methods);
}

std::vector<double> frame_times(const Scenario& scenario) {
  std::vector<double> times;
  for (const std::int64_t t_ns : sample_times(scenario.stereo_rate, scenario.duration)) {
    times.push_back(static_cast<double>(t_ns) / 1e9);
  }
  return times;
}

RunOptions run_options(const Scenario& scenario, const MethodVariant& variant, StartMode start,
                       std::uint64_t seed, std::uint64_t run) {
  const FilterScenario& filter = scenario.filter;
  RunOptions options;
  options.method = variant.method;
  options.constraints = variant.constraints;
  if (!variant.estimate.empty()) {
    options.estimated = parse_parameter_sigmas(variant.estimate, nominal_calibration(scenario));
  }
  if (!variant.soften.empty()) {
    options.softened = parse_parameter_sigmas(variant.soften, nominal_calibration(scenario));
  }
  if (!variant.assume.empty()) {
    options.assume_error = parse_calibration_error(variant.assume, nominal_calibration(scenario));
  }
  options.landmarks = variant.landmarks;
  options.start = start;
  options.initial = filter.initial;
  options.initial_error = scenario.initial;
  options.theta_sigma = filter.theta_sigma;
  options.theta_walk = theta_walk(scenario, variant.walk);
  options.constant_velocity_noise = ConstantVelocityNoise{filter.acceleration_noise, filter.angular_noise};
  options.gravity = scenario.gravity;
  options.gate = filter.gate;
  options.max_landmarks = static_cast<std::size_t>(filter.max_landmarks);
  options.seed = seed;
  options.run = run;
  // Whether inputs misled ekf is asked where one fails, and needs the rig's verdict.
  options.watch = variant.method == Method::kEkf && filter.gate && !scenario.faults.empty();
  options.stop_when_lost = true;
  return options;
}

}  // namespace limber
