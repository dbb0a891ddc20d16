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

constexpr std::size_t kVerdict = 1, kAlarm = 2, kPValue = 3, kDelta = 4, kSigma = 10, kSince = 16,
                      kGatheredPValue = 17, kGatheredDelta = 18, kGatheredSigma = 24, kAxes = 30,
                      kChanged = 36, kColumns = 37;

constexpr std::array kVerdicts = {HealthVerdict::kOk, HealthVerdict::kSuspect, HealthVerdict::kDecalibrated,
                                  HealthVerdict::kCannotTell};

void add_six(std::vector<std::string>& names, const std::string& what) {
  for (std::size_t k = 0; k < 6; ++k) {
    names.push_back(what + "_" + std::string(kParameterNames[k]) + (k < 3 ? " [deg]" : " [mm]"));
  }
}

std::vector<std::string> health_columns() {
  std::vector<std::string> names = {"t_ns", "verdict", "alarm", "p_value [-]"};
  add_six(names, "delta");
  add_six(names, "sigma");
  names.insert(names.end(), {"gathered_since_ns", "gathered_p_value [-]"});
  add_six(names, "gathered_delta");
  add_six(names, "gathered_sigma");
  for (std::size_t k = 0; k < 6; ++k) {
    names.push_back("verdict_" + std::string(kParameterNames[k]));
  }
  names.emplace_back("changed_ns");
  return names;
}

void add_row(const HealthReport& report, detail::TableText& table) {
  table.time(report.t_ns);
  table.cell(to_string(report.verdict));
  table.cell(std::int64_t{report.alarm});
  table.cell(report.p_value);
  table.cells(in_degrees_and_mm(report.delta));
  table.cells(in_degrees_and_mm(report.sigma));
  table.cell(report.gathered_since_ns);
  table.cell(report.gathered_p_value);
  table.cells(in_degrees_and_mm(report.gathered_delta));
  table.cells(in_degrees_and_mm(report.gathered_sigma));
  for (const HealthVerdict axis : report.axes) {
    table.cell(to_string(axis));
  }
  if (report.changed_ns) {
    table.cell(*report.changed_ns);
  } else {
    table.empty_cells(1);
  }
  table.end_row();
}

HealthVerdict verdict(const detail::TableReader& table, std::size_t column) {
  for (const HealthVerdict verdict : kVerdicts) {
    if (table.field(column) == to_string(verdict)) {
      return verdict;
    }
  }
  table.fail("ok, suspect, decalibrated or cannot tell", std::string(table.field(column)));
}

RigParameters six(const detail::TableReader& table, std::size_t column) {
  const RigParameters unit = in_degrees_and_mm(RigParameters::Ones());
  RigParameters out;
  out << table.vector3(column), table.vector3(column + 3);
  return out.cwiseQuotient(unit);
}

HealthReport health_row(detail::TableReader& table) {
  HealthReport out;
  out.t_ns = table.increasing_time();
  out.verdict = verdict(table, kVerdict);
  out.alarm = table.integer(kAlarm) != 0;
  out.p_value = table.number(kPValue);
  out.delta = six(table, kDelta);
  out.sigma = six(table, kSigma);
  out.gathered_since_ns = table.integer(kSince);
  out.gathered_p_value = table.number(kGatheredPValue);
  out.gathered_delta = six(table, kGatheredDelta);
  out.gathered_sigma = six(table, kGatheredSigma);
  for (std::size_t k = 0; k < 6; ++k) {
    out.axes[k] = verdict(table, kAxes + k);
  }
  if (!table.field(kChanged).empty()) {
    out.changed_ns = table.integer(kChanged);
  }
  return out;
}

}  // namespace

void write_health_csv(const std::filesystem::path& path, std::span<const FrameReport> frames) {
  detail::TableText table("health.csv", ',');
  table.header(detail::header_of(health_columns()));
  for (const FrameReport& frame : frames) {
    if (frame.health) {
      add_row(*frame.health, table);
    }
  }
  write_file_atomically(path, table.text());
}

std::vector<HealthReport> read_health_csv(const std::filesystem::path& path) {
  const std::vector<std::string> names = health_columns();
  detail::TableReader table(path, {.names = {names.begin(), names.end()}, .counts = {kColumns}});
  std::vector<HealthReport> rows;
  while (table.next()) {
    rows.push_back(health_row(table));
  }
  table.require_a_row("frame");
  return rows;
}

}  // namespace limber
