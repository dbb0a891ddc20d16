// SPDX-License-Identifier: MIT
#include "limber/run_files/run_results.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "limber/core/time.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/sensors/parameters.hpp"
#include "run_files/run_folder.hpp"

namespace limber {
namespace {

namespace fs = std::filesystem;
using Level = Diagnostic::Level;

Level level_of(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return Level::kOk;
    case HealthVerdict::kSuspect:
    case HealthVerdict::kDegraded:
      return Level::kWarning;
    case HealthVerdict::kDecalibrated:
      return Level::kError;
    case HealthVerdict::kCannotTell:
      break;
  }
  return Level::kStale;
}

constexpr double kSameInstant_s = 1e-4;  // seconds of this century have that many digits

std::string number(double value) { return fmt::format("{:.4g}", value); }

void add(const std::string& name, const SizeInterval& interval, double unit, Diagnostic& out) {
  out.values.emplace_back(name, number(unit * interval.size));
  out.values.emplace_back(name + " low", number(unit * interval.low));
  out.values.emplace_back(name + " high", number(unit * interval.high));
}

/// What is wrong with a frame; empty: nothing.
std::string remark_on(const FrameRow& row, bool is_lost) {
  if (is_lost) {
    return "the run is lost: no position and no sigma since then is true";
  }
  if (row.status != UpdateStatus::kUpdated) {
    return "the frame corrected nothing: " + to_string(row.status);
  }
  if (row.inputs != InputStatus::kNotNeeded && row.inputs != InputStatus::kSound) {
    return "inputs: " + to_string(row.inputs);
  }
  return {};
}

}  // namespace

Diagnostic calibration_diagnostic(const HealthRow& row) {
  Diagnostic out{row.t_ns, level_of(row.verdict), "limber: calibration", {}, {}};
  out.message = fmt::format(
      "{}: {:.2g} px off the epipolar lines ({:.2g} to {:.2g}), {:.2g} % of depth ({:.2g} to {:.2g})",
      to_string(row.verdict), row.epipolar_px.size, row.epipolar_px.low, row.epipolar_px.high,
      100.0 * row.depth.size, 100.0 * row.depth.low, 100.0 * row.depth.high);
  out.values.emplace_back("verdict", to_string(row.verdict));
  out.values.emplace_back("verdict of the window", to_string(row.window_verdict));
  out.values.emplace_back("since [ns]", std::to_string(row.since_ns));
  add("epipolar [px]", row.epipolar_px, 1.0, out);
  add("depth [%]", row.depth, 100.0, out);
  const RigParameters delta = in_degrees_and_mm(row.delta), sigma = in_degrees_and_mm(row.sigma);
  for (std::size_t k = 0; k < 6; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const std::string name(kParameterNames[k]);
    const std::string unit = k < 3 ? " [deg]" : " [mm]";
    out.values.emplace_back(name + unit, number(delta(i)));
    out.values.emplace_back(name + " sigma" + unit, number(sigma(i)));
    out.values.emplace_back(name + " verdict", to_string(row.axes[k]));
  }
  return out;
}

Diagnostic navigation_diagnostic(const FrameRow& row, bool is_lost) {
  const std::string remark = remark_on(row, is_lost);
  const Level level = is_lost ? Level::kError : remark.empty() ? Level::kOk : Level::kWarning;
  Diagnostic out{row.t_ns, level, "limber: navigation", remark.empty() ? "ok" : remark, {}};
  const auto add_count = [&](const char* name, std::size_t n) {
    out.values.emplace_back(name, std::to_string(n));
  };
  out.values.emplace_back("status", to_string(row.status));
  out.values.emplace_back("inputs", to_string(row.inputs));
  out.values.emplace_back("longest gap [s]", number(row.gap_s));
  add_count("points seen", row.observed);
  add_count("points used", row.used);
  add_count("points refused", row.refused);
  out.values.emplace_back("NIS", number(row.nis));
  add_count("degrees of freedom", row.dof);
  add_count("constrained directions", row.rank);
  return out;
}

bool is_run_folder(const fs::path& folder) {
  return fs::is_regular_file(folder / "summary.json") && fs::is_regular_file(folder / "trajectory.csv");
}

RunResults read_run_results(const fs::path& folder) {
  detail::RunFolder run = detail::read_run_folder(folder);
  RunResults out;
  out.trajectory = std::move(run.trajectory);
  if (fs::exists(folder / "truth.tum")) {
    out.truth = read_tum(folder / "truth.tum");
  }
  out.landmarks = std::move(run.landmarks);
  const std::optional<double> lost_since_s = detail::number_at(run.summary, {"lost_since_s"});
  bool is_lost = false;
  for (const FrameRow& row : run.frames) {
    const double now_s = to_seconds(row.t_ns);
    is_lost = is_lost || row.reset || (lost_since_s && now_s >= *lost_since_s - kSameInstant_s);
    out.diagnostics.push_back(navigation_diagnostic(row, is_lost));
  }
  for (const HealthRow& row : run.health) {
    out.diagnostics.push_back(calibration_diagnostic(row));
  }
  const auto earlier = [](const Diagnostic& a, const Diagnostic& b) { return a.t_ns < b.t_ns; };
  std::stable_sort(out.diagnostics.begin(), out.diagnostics.end(), earlier);
  return out;
}

}  // namespace limber
