// SPDX-License-Identifier: MIT
// Does the health monitor keep what it promises? Simulates the paper's rig and prints how often a sound one
// raises an alarm, how soon steps are found, and which axes are named.
//
//   health_statistics [--hours H] [--runs N] [--rate PER_HOUR] [--method lcekf] [--seed S] [--threads T]
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "limber/core/chi_square.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"
#include "limber/study/study_plan.hpp"

namespace {

using namespace limber;

constexpr double kStep = 10.0;                                                   // [s], when a rig is bent
constexpr std::array<double, 6> kPaper = {0.01, -0.05, 0.1, 0.1, -0.01, 0.005};  // [deg, m]

struct Settings {
  double hours = 10.0, rate = 6.0;
  std::uint64_t runs = 50, seed = 1;
  int threads = 0;
  std::string method = "lcekf";
};

std::string step_scenario(const std::array<double, 6>& amplitude, double duration) {
  return fmt::format(
      "duration: {}\ndecalibration:\n  - shape: steps\n    steps: [{{at: {}, value: 1}}]\n    amplitude: "
      "[{}]\n",
      duration, kStep, fmt::join(amplitude, ", "));
}

/// What the monitor said in one run; new alarms only.
struct Outcome {
  int alarms = 0;
  double delay = -1.0;                     ///< [s] from the step to the first alarm after it; negative: none
  std::array<bool, 6> named{};             ///< half a second after the alarm
  std::array<double, 6> sigma{};           ///< of a frame, at the step [rad, m]
  std::array<double, 6> gathered_sigma{};  ///< of the last whole window [rad, m]
  double noncentrality = 0.0;              ///< largest that the witness could show within 5 s of the step [-]
};

RigParameters in_si(const std::array<double, 6>& amplitude) {
  RigParameters out;
  for (std::size_t k = 0; k < 6; ++k) {
    out(static_cast<Eigen::Index>(k)) = amplitude[k] * (k < 3 ? M_PI / 180.0 : 1.0);
  }
  return out;
}

/// P(X > x) of a non-central chi-square: a Poisson mixture of central ones.
double noncentral_survival(double x, double dof, double noncentrality) {
  double sum = 0.0, weight = std::exp(-0.5 * noncentrality);
  for (int k = 0; k < 1000 && noncentrality < 1000.0; ++k) {
    sum += weight * chi_square_survival(x, dof + 2.0 * k);
    weight *= 0.5 * noncentrality / (k + 1.0);
  }
  return noncentrality < 1000.0 ? sum : 1.0;
}

/// Chance that a window shows it, if the test is that of the monitor and all is Gaussian: its best look
/// alone.
double achievable(double noncentrality, double rate) {
  const double p = 0.5 * rate * HealthOptions{}.window_s / 3600.0 / 5.0;
  return noncentral_survival(chi_square_quantile(1.0 - p, 6.0), 6.0, noncentrality);
}

Outcome watch(const Scenario& scenario, const Settings& settings, std::uint64_t run,
              const RigParameters& amplitude = RigParameters::Zero()) {
  const Recording recording = simulate(scenario, settings.seed, run);
  MethodVariant variant;
  variant.method = method_from_string(settings.method);
  RunOptions options = run_options(scenario, variant, StartMode::kGroundTruth, settings.seed, run);
  options.false_alarms_per_hour = settings.rate;
  options.watch = true;
  const RunRecord record = run_recording(recording, options, matched_frames(recording));
  Outcome out;
  bool was_alarmed = false;
  double alarm_s = -1.0;
  for (const FrameReport& frame : record.frames) {
    if (!frame.health) {
      continue;
    }
    const HealthReport& health = *frame.health;
    const double t = 1e-9 * static_cast<double>(health.t_ns);
    const bool is_new = health.alarm && !was_alarmed;
    was_alarmed = health.changed_ns.has_value();
    out.alarms += is_new ? 1 : 0;
    if (t < kStep - 1e-6) {
      for (std::size_t k = 0; k < 6; ++k) {
        out.sigma[k] = health.sigma(static_cast<Eigen::Index>(k));
        out.gathered_sigma[k] = health.gathered_sigma(static_cast<Eigen::Index>(k));
      }
    } else if (health.alarm && out.delay < 0.0) {
      out.delay = t - kStep;
      alarm_s = t;
    }
    if (t >= kStep && t <= kStep + 5.0 && frame.evidence && frame.evidence->gathered &&
        1e-9 * static_cast<double>(health.gathered_since_ns) >= kStep - 0.1) {
      const RigParameters beta = frame.evidence->directions.colPivHouseholderQr().solve(amplitude);
      out.noncentrality = std::max(out.noncentrality, beta.dot(frame.evidence->gathered->information * beta));
    }
    if (alarm_s >= 0.0 && t <= alarm_s + 0.5) {
      for (std::size_t k = 0; k < 6; ++k) {
        out.named[k] = health.axes[k] == HealthVerdict::kDecalibrated;
      }
    }
  }
  return out;
}

std::vector<Outcome> watch_all(const std::string& text, const Settings& settings, std::uint64_t runs,
                               const RigParameters& amplitude = RigParameters::Zero()) {
  const Scenario scenario = parse_scenario(text, "health.yaml");
  std::vector<Outcome> out(runs);
  tbb::parallel_for(std::uint64_t{0}, runs,
                    [&](std::uint64_t run) { out[run] = watch(scenario, settings, run, amplitude); });
  return out;
}

void false_alarms(const Settings& settings) {
  constexpr double kDuration = 35.0;
  const auto runs = static_cast<std::uint64_t>(std::ceil(settings.hours * 3600.0 / kDuration));
  int alarms = 0;
  for (const Outcome& run : watch_all(fmt::format("duration: {}\n", kDuration), settings, runs)) {
    alarms += run.alarms;
  }
  const double hours = static_cast<double>(runs) * kDuration / 3600.0;
  fmt::print("sound rig: {} alarms in {:.2f} h = {:.2f} per hour, asked for {:g}\n", alarms, hours,
             alarms / hours, settings.rate);
}

void step(const char* name, const std::array<double, 6>& amplitude, const Settings& settings) {
  const std::vector<Outcome> runs =
      watch_all(step_scenario(amplitude, kStep + 6.0), settings, settings.runs, in_si(amplitude));
  int two_frames = 0, five_seconds = 0;
  double worst = 0.0, chance = 0.0;
  std::array<int, 6> named{}, larger{};
  std::array<double, 6> sigma{}, gathered{};
  for (const Outcome& run : runs) {
    two_frames += run.delay >= 0.0 && run.delay < 0.075 ? 1 : 0;
    five_seconds += run.delay >= 0.0 && run.delay <= 5.0 ? 1 : 0;
    chance += achievable(run.noncentrality, settings.rate) / static_cast<double>(runs.size());
    worst = run.delay < 0.0 ? INFINITY : std::max(worst, run.delay);
    for (std::size_t k = 0; k < 6; ++k) {
      const double unit = k < 3 ? M_PI / 180.0 : 1.0;
      named[k] += run.named[k] ? 1 : 0;
      larger[k] += std::abs(amplitude[k]) * unit > 5.0 * run.sigma[k] ? 1 : 0;
      sigma[k] += run.sigma[k] / unit / static_cast<double>(runs.size());
      gathered[k] += run.gathered_sigma[k] / unit / static_cast<double>(runs.size());
    }
  }
  fmt::print(
      "\nstep {}: {} runs, found within 2 frames in {}, within 5 s in {}, slowest {:.2f} s; a window of the "
      "witness "
      "alone, since then, would show it in {:.0f} % of them\n",
      name, runs.size(), two_frames, five_seconds, worst, 100.0 * chance);
  fmt::print("  axis      step   sigma of a frame   of a window   |step| > 5 sigma of a frame   named\n");
  for (std::size_t k = 0; k < 6; ++k) {
    fmt::print("  {}  {:9.4f} {:18.4f} {:13.4f} {:29} {:7}\n", kParameterNames[k], amplitude[k], sigma[k],
               gathered[k], larger[k], named[k]);
  }
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("What the health monitor keeps of its promises");
  app.add_option("--hours", settings.hours, "simulated hours of a sound rig; 0: none")->capture_default_str();
  app.add_option("--runs", settings.runs, "of each step")->capture_default_str();
  app.add_option("--rate", settings.rate, "false alarms per hour asked for")->capture_default_str();
  app.add_option("--method", settings.method)->capture_default_str();
  app.add_option("--seed", settings.seed)->capture_default_str();
  app.add_option("--threads", settings.threads, "0: one per core")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  settings.threads > 0 ? static_cast<std::size_t>(settings.threads) : 1024);
  if (settings.hours > 0.0) {
    false_alarms(settings);
  }
  if (settings.runs > 0) {
    step("of the paper", kPaper, settings);
    std::array<double, 6> tenth = kPaper;
    for (double& value : tenth) {
      value *= 0.1;
    }
    step("of a tenth of it", tenth, settings);
    for (std::size_t k = 0; k < 6; ++k) {
      std::array<double, 6> single{};
      single[k] = kPaper[k];
      step(fmt::format("of {} alone", kParameterNames[k]).c_str(), single, settings);
    }
  }
  return 0;
}
