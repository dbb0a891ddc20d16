// SPDX-License-Identifier: MIT
#include "limber/run_files/frames_file.hpp"

#include <array>
#include <string>

#include "io/text_file.hpp"

namespace limber {
namespace {

/// Older files lack the noise of pixels and the test of the inputs, or how noisy an IMU is.
constexpr std::size_t kFrameColumnsOfOld = 17, kFrameColumnsWithTest = 19, kFrameColumns = 21;

std::size_t count(const detail::TableReader& table, std::size_t column) {
  const std::int64_t value = table.integer(column);
  if (value < 0) {
    table.fail("a count", std::to_string(value));
  }
  return static_cast<std::size_t>(value);
}

/// The one of `values` whose text stands in a column.
template <typename Enumerator, std::size_t n>
Enumerator one_of(const std::array<Enumerator, n>& values, const detail::TableReader& table,
                  std::size_t column) {
  std::string expected;
  for (const Enumerator value : values) {
    if (table.field(column) == to_string(value)) {
      return value;
    }
    expected += (expected.empty() ? "" : ", ") + to_string(value);
  }
  table.fail("one of " + expected, std::string(table.field(column)));
}

constexpr std::array kUpdates = {UpdateStatus::kUpdated, UpdateStatus::kEmpty,
                                 UpdateStatus::kSingularInnovation};
constexpr std::array kInputs = {InputStatus::kNotNeeded, InputStatus::kSound,        InputStatus::kFaulty,
                                InputStatus::kGap,       InputStatus::kContradicted, InputStatus::kNone};

}  // namespace

FrameRow frame_row(const FrameReport& report) {
  FrameRow row;
  row.t_ns = report.t_ns;
  row.observed = report.observed;
  row.used = report.used;
  row.initialized = report.initialized;
  row.removed = report.removed;
  row.refused = report.refused.size();
  row.gate_overruled = report.gate_overruled;
  row.nis = report.nis;
  row.dof = static_cast<std::size_t>(report.dof);
  row.rank = static_cast<std::size_t>(report.rank);
  row.status = report.status;
  row.inputs = report.inputs.status;
  row.gap_s = report.inputs.gap_s;
  row.reset = report.reset;
  row.sigma_px = report.sigma_px;
  row.inputs_chi2 = report.inputs.chi2;
  row.imu_noise = report.imu_noise;
  return row;
}

std::vector<FrameRow> read_frames_csv(const std::filesystem::path& path) {
  detail::TableReader table(path, {.names = {"t_ns",
                                             "observed",
                                             "used",
                                             "initialized",
                                             "removed",
                                             "refused",
                                             "gate_overruled",
                                             "nis [-]",
                                             "dof",
                                             "constrained_rank",
                                             "status",
                                             "inputs",
                                             "gap_s",
                                             "faulty_samples",
                                             "reset",
                                             "sigma_px [px]",
                                             "inputs_chi2 [-]",
                                             "gyro_noise [-]",
                                             "accel_noise [-]",
                                             "filter_ms",
                                             "source_ms"},
                                   .counts = {kFrameColumnsOfOld, kFrameColumnsWithTest, kFrameColumns}});
  std::vector<FrameRow> rows;
  while (table.next()) {
    FrameRow row;
    row.t_ns = table.increasing_time();
    row.observed = count(table, 1);
    row.used = count(table, 2);
    row.initialized = count(table, 3);
    row.removed = count(table, 4);
    row.refused = count(table, 5);
    row.gate_overruled = count(table, 6) != 0;
    row.nis = table.number(7);
    row.dof = count(table, 8);
    row.rank = count(table, 9);
    row.status = one_of(kUpdates, table, 10);
    row.inputs = one_of(kInputs, table, 11);
    row.gap_s = table.number(12);
    row.reset = count(table, 14) != 0;
    if (table.columns() >= kFrameColumnsWithTest) {
      row.sigma_px = table.number(15);
      row.inputs_chi2 = table.number(16);
    }
    if (table.columns() == kFrameColumns) {
      row.imu_noise = {table.number(17), table.number(18)};
    }
    row.filter_ms = table.number(table.columns() - 2);
    row.source_ms = table.number(table.columns() - 1);
    rows.push_back(row);
  }
  table.require_a_row("frame");
  return rows;
}

}  // namespace limber
