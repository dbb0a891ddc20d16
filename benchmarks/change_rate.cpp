// SPDX-License-Identifier: MIT
// How often a sound rig is said to have changed or to drift, over hours: simulated points seen from their
// true poses, so that an hour takes half a minute. scripts/change_rate_table.py asks the whole program, at a
// tenth of the speed.
//
//   change_rate SCENARIO... [--hours H] [--rate PER_HOUR] [--seed S] [--seconds S] [--pixels KIND]
//               [--tolerance chance|default]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "limber/core/chi_square.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/health/calibration_watch.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "limber/simulate/simulator.hpp"

namespace {

using namespace limber;

struct Settings {
  double hours = 10.0, rate = 6.0, seconds = 600.0;
  std::uint64_t seed = 1;
  std::string pixels = "realistic", tolerance = "chance";
  std::vector<std::filesystem::path> scenarios;
};

/// How changes are judged: by the default tolerance, or by one so small that chance alone decides.
WatchOptions judge_options(const Settings& settings) {
  WatchOptions out;
  out.false_alarms_per_hour = settings.rate;
  if (settings.tolerance == "chance") {
    out.tolerance.epipolar_px.ok = 0.001;
    out.tolerance.depth.ok = 0.0001;
  }
  return out;
}

struct Found {
  int changes = 0, drifts = 0;
};

Found found_in(const Recording& recording, const WatchOptions& options) {
  CalibrationWatch watch(options, recording.calibration, true);
  std::shared_ptr<const CalibrationReport> last;
  Found out;
  bool drifts = false;
  for (const StereoFrame& frame : recording.frames) {
    if (const auto truth = groundtruth_at(recording.truth.motion.states, frame.t_ns)) {
      const Pose T_world_body{truth->R_world_body, truth->p_world_body};
      watch.add(frame, T_world_body * recording.calibration.T_body_cam0, {});
    }
    if (watch.report() != last) {
      last = watch.report();
      out.changes += static_cast<int>(last->past.size());
      drifts = drifts && last->past.empty();  // a state that is new has a drift of its own
      out.drifts += last->state.drift && !drifts ? 1 : 0;
      drifts = last->state.drift.has_value();
    }
  }
  return out;
}

void print_row(const std::string& name, const Settings& settings, const Found& found, double hours) {
  const auto mean_at = [&](double share, int events) {
    return events > 0 ? 0.5 * chi_square_quantile(share, 2.0 * events) / hours : 0.0;
  };
  const int events = found.changes + found.drifts;
  fmt::print("| {}, {} | {} | {:.2f} | {:g} | {} | {} | {:.2f} ({:.2f} to {:.2f}) |\n", name, settings.pixels,
             settings.tolerance, hours, settings.rate, found.changes, found.drifts, events / hours,
             mean_at(0.025, events), mean_at(0.975, events + 1));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("How often limber health says that a sound rig changed");
  Settings settings;
  app.add_option("scenarios", settings.scenarios)->required();
  app.add_option("--hours", settings.hours);
  app.add_option("--rate", settings.rate, "false alarms per hour that are asked for");
  app.add_option("--seed", settings.seed, "of the first recording");
  app.add_option("--seconds", settings.seconds, "of a recording");
  app.add_option("--pixels", settings.pixels)->check(CLI::IsMember({"white", "realistic"}));
  app.add_option("--tolerance", settings.tolerance)->check(CLI::IsMember({"chance", "default"}));
  CLI11_PARSE(app, argc, argv);
  fmt::print(
      "| scenario, pixels | tolerance | hours | asked per hour | changes | drifts | per hour (95 %) |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const std::filesystem::path& path : settings.scenarios) {
    Scenario scenario = read_scenario(path);
    scenario.duration = settings.seconds;
    set_pixels(scenario, settings.pixels == "white" ? PixelPreset::kWhite : PixelPreset::kRealistic);
    const auto runs = static_cast<std::uint64_t>(std::ceil(settings.hours * 3600.0 / settings.seconds));
    Found found;
    for (std::uint64_t run = 0; run < runs; ++run) {
      const Found one = found_in(simulate(scenario, settings.seed + run), judge_options(settings));
      found.changes += one.changes;
      found.drifts += one.drifts;
    }
    print_row(path.stem().string(), settings, found, static_cast<double>(runs) * settings.seconds / 3600.0);
  }
}
