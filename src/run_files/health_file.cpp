// SPDX-License-Identifier: MIT
#include "limber/run_files/health_file.hpp"

#include <array>
#include <cstddef>
#include <string>

#include "io/table_text.hpp"
#include "io/text_file.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber {
namespace {

constexpr std::size_t kVerdict = 4, kEpipolar = 6, kDepth = 9, kDelta = 13, kSigma = 19, kWindowDelta = 25,
                      kWindowSigma = 31, kAxes = 37, kColumns = 43;

constexpr std::array kVerdicts = {HealthVerdict::kOk, HealthVerdict::kDegraded, HealthVerdict::kDecalibrated,
                                  HealthVerdict::kCannotTell};

void add_six(std::vector<std::string>& names, const std::string& what) {
  for (std::size_t k = 0; k < 6; ++k) {
    names.push_back(what + "_" + std::string(kParameterNames[k]) + (k < 3 ? " [deg]" : " [mm]"));
  }
}

std::vector<std::string> health_columns() {
  std::vector<std::string> names = {"t_ns",           "window_from_ns",    "since_ns",
                                    "changed",        "verdict",           "window_verdict",
                                    "epipolar [px]",  "epipolar_low [px]", "epipolar_high [px]",
                                    "depth [%]",      "depth_low [%]",     "depth_high [%]",
                                    "depth_error [%]"};
  add_six(names, "delta");
  add_six(names, "sigma");
  add_six(names, "window_delta");
  add_six(names, "window_sigma");
  for (std::size_t k = 0; k < 6; ++k) {
    names.push_back("verdict_" + std::string(kParameterNames[k]));
  }
  return names;
}

void add(const SizeInterval& interval, double unit, detail::TableText& table) {
  table.cell(unit * interval.size);
  table.cell(unit * interval.low);
  table.cell(unit * interval.high);
}

void add_row(const HealthRow& row, detail::TableText& table) {
  table.time(row.t_ns);
  table.cell(row.window_from_ns);
  table.cell(row.since_ns);
  table.cell(std::int64_t{row.changed});
  table.cell(to_string(row.verdict));
  table.cell(to_string(row.window_verdict));
  add(row.epipolar_px, 1.0, table);
  add(row.depth, 100.0, table);
  table.cell(100.0 * row.depth_signed);
  for (const RigParameters& six : {row.delta, row.sigma, row.window_delta, row.window_sigma}) {
    table.cells(in_degrees_and_mm(six));
  }
  for (const HealthVerdict axis : row.axes) {
    table.cell(to_string(axis));
  }
  table.end_row();
}

HealthVerdict verdict(const detail::TableReader& table, std::size_t column) {
  for (const HealthVerdict verdict : kVerdicts) {
    if (table.field(column) == to_string(verdict)) {
      return verdict;
    }
  }
  table.fail("ok, degraded, decalibrated or cannot tell", std::string(table.field(column)));
}

SizeInterval interval(const detail::TableReader& table, std::size_t column, double unit) {
  return {table.number(column) / unit, table.number(column + 1) / unit, table.number(column + 2) / unit};
}

RigParameters six(const detail::TableReader& table, std::size_t column) {
  const RigParameters unit = in_degrees_and_mm(RigParameters::Ones());
  RigParameters out;
  out << table.vector3(column), table.vector3(column + 3);
  return out.cwiseQuotient(unit);
}

HealthRow read_row(detail::TableReader& table) {
  HealthRow out;
  out.t_ns = table.increasing_time();
  out.window_from_ns = table.integer(1);
  out.since_ns = table.integer(2);
  out.changed = table.integer(3) != 0;
  out.verdict = verdict(table, kVerdict);
  out.window_verdict = verdict(table, kVerdict + 1);
  out.epipolar_px = interval(table, kEpipolar, 1.0);
  out.depth = interval(table, kDepth, 100.0);
  out.depth_signed = table.number(kDepth + 3) / 100.0;
  out.delta = six(table, kDelta);
  out.sigma = six(table, kSigma);
  out.window_delta = six(table, kWindowDelta);
  out.window_sigma = six(table, kWindowSigma);
  for (std::size_t k = 0; k < 6; ++k) {
    out.axes[k] = verdict(table, kAxes + k);
  }
  return out;
}

}  // namespace

HealthRow health_row(const CalibrationReport& report) {
  const CalibrationState &state = report.state, &window = report.window;
  HealthRow out;
  out.t_ns = report.window.to_ns;
  out.window_from_ns = window.from_ns;
  out.since_ns = state.from_ns;
  out.changed = !report.past.empty();
  out.verdict = state.verdict;
  out.window_verdict = window.verdict;
  out.epipolar_px = state.effect.epipolar_px;
  out.depth = state.effect.depth;
  out.depth_signed = state.effect.depth_signed;
  out.delta = state.estimate.delta;
  out.sigma = state.estimate.sigma();
  out.window_delta = window.estimate.delta;
  out.window_sigma = window.estimate.sigma();
  out.axes = state.axes;
  return out;
}

void write_health_csv(const std::filesystem::path& path, std::span<const FrameReport> frames) {
  detail::TableText table("health.csv", ',');
  table.header(detail::header_of(health_columns()));
  const CalibrationReport* last = nullptr;
  for (const FrameReport& frame : frames) {
    if (frame.calibration && frame.calibration.get() != last) {
      last = frame.calibration.get();
      add_row(health_row(*last), table);
    }
  }
  write_file_atomically(path, table.text());
}

std::vector<HealthRow> read_health_csv(const std::filesystem::path& path) {
  const std::vector<std::string> names = health_columns();
  detail::TableReader table(path, {.names = {names.begin(), names.end()}, .counts = {kColumns}});
  std::vector<HealthRow> rows;
  while (table.next()) {
    rows.push_back(read_row(table));
  }
  table.require_a_row("window");
  return rows;
}

}  // namespace limber
