// SPDX-License-Identifier: MIT
#include "fleet.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "commands.hpp"
#include "fleet_trend.hpp"
#include "health_since.hpp"
#include "ordered_json.hpp"
#include "text_table.hpp"

namespace limber::app {
namespace {

using Row = TextRow;

/// Of the first frame, in UTC; "-" where stamps do not count from 1970.
std::string date_of(const Diagnosis& diagnosis) {
  if (!diagnosis.health || !is_dated(diagnosis.health->begin_ns)) {
    return "-";
  }
  return fmt::format("{:%Y-%m-%d}",
                     fmt::gmtime(static_cast<std::time_t>(diagnosis.health->begin_ns / 1'000'000'000)));
}

/// The intervals of what it does, and the axes.
void add_sizes(Row& row, const CalibrationState& state) {
  const CalibrationEffect& effect = state.effect;
  row.push_back(fmt::format("{:.2f}–{:.2f}", effect.epipolar_px.low, effect.epipolar_px.high));
  row.push_back(fmt::format("{:.1f}–{:.1f}", 100.0 * effect.depth.low, 100.0 * effect.depth.high));
  const RigParameters delta = in_degrees_and_mm(state.estimate.delta);
  const RigParameters sigma = in_degrees_and_mm(state.estimate.sigma());
  for (Eigen::Index k = 0; k < 6; ++k) {
    row.push_back(fmt::format("{:+.{}f}±{:.{}f}", delta(k), k < 3 ? 2 : 1, sigma(k), k < 3 ? 2 : 1));
  }
}

Row row_of(const FleetRow& of) {
  if (!of.diagnosis) {
    return {of.dataset, "-", of.stopped ? "not judged" : "failed: " + of.failure};
  }
  const Diagnosis& d = *of.diagnosis;
  Row row = {of.dataset, date_of(d), to_string(verdict_of(d))};
  if (d.stopped) {
    row.back() += fmt::format(" (partial: {} of {} frames)", d.frames, d.frames_of_recording);
  }
  if (d.health) {
    add_sizes(row, d.health->present);
  }
  return row;
}

Row change_of(const FleetRow& of) {
  const SinceThen& since = *of.diagnosis->since;
  Row row = {of.dataset, "since " + since.recording, to_string(since.change.verdict)};
  add_sizes(row, since.change);
  return row;
}

}  // namespace

void compare_with_first(std::vector<FleetRow>& rows) {
  for (std::size_t k = 1; k < rows.size(); ++k) {
    if (!rows[k].diagnosis || !rows[k].diagnosis->state) {
      continue;
    }
    const auto first =
        std::find_if(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(k), [&](const FleetRow& r) {
          return r.diagnosis && r.diagnosis->state &&
                 r.diagnosis->state->cameras == rows[k].diagnosis->state->cameras;
        });
    if (first != rows.begin() + static_cast<std::ptrdiff_t>(k)) {
      rows[k].diagnosis->since = since_then(first->diagnosis->state, *rows[k].diagnosis);
      rows[k].diagnosis->since->recording = first->dataset;
    }
  }
}

int fleet_exit_code(const std::vector<FleetRow>& rows) {
  HealthVerdict all = HealthVerdict::kOk;
  for (const FleetRow& row : rows) {
    if (!row.diagnosis || row.diagnosis->stopped) {
      return kExitFailed;
    }
    all = worst(all, verdict_of(*row.diagnosis));
  }
  return exit_code(all);
}

std::string fleet_text(const std::vector<FleetRow>& rows) {
  const Row head = {"recording", "date",     "verdict", "px (95 %)", "depth % (95 %)", "ax [deg]",
                    "ay [deg]",  "az [deg]", "tx [mm]", "ty [mm]",   "tz [mm]"};
  std::vector<Row> now = {head}, moved = {head};
  moved.front()[1] = "";
  for (const FleetRow& row : rows) {
    now.push_back(row_of(row));
    if (row.diagnosis && row.diagnosis->since) {
      moved.push_back(change_of(row));
    }
  }
  std::string out = "True minus assumed, in the present state\n" + text_table(now);
  if (moved.size() > 1) {
    out += "\nHow each moved since the first with the same cameras\n" + text_table(moved);
  }
  for (const FleetTrend& trend : fleet_trends(rows)) {
    out += "\n" + to_text(trend, rows);
  }
  return out;
}

std::string fleet_json(const std::vector<FleetRow>& rows) {
  Json out = Json::array();
  for (const FleetRow& row : rows) {
    out.push_back(row.diagnosis ? Json::parse(to_json(*row.diagnosis))
                                : Json{{"dataset", row.dataset},
                                       {"failure", row.stopped ? "not judged: stopped" : row.failure}});
    out.back()["trend"] = nullptr;
  }
  for (const FleetTrend& trend : fleet_trends(rows)) {
    for (const std::size_t k : trend.rows) {
      out[k]["trend"] = to_json(trend);
    }
  }
  return json_text(out);
}

}  // namespace limber::app
