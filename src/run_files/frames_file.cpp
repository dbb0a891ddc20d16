// SPDX-License-Identifier: MIT
#include "limber/run_files/frames_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <iterator>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_file.hpp"
#include "limber/io/atomic_file.hpp"

namespace limber {
namespace {

struct Column {
  enum : std::size_t {
    kTime,
    kObserved,
    kUsed,
    kInitialized,
    kRemoved,
    kRefused,
    kGateOverruled,
    kNis,
    kDof,
    kRank,
    kStatus,
    kInputs,
    kGap,
    kFaultySamples,
    kReset,
    kSigmaPixels,
    kInputsChi2,
    kGyroNoise,
    kAccelNoise,
  };
};

const std::vector<std::string_view> kFrameColumnNames = {"t_ns",
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
                                                         "source_ms"};

/// Times spent stand last. Older files lack the noise of pixels and the test of the inputs before them, or
/// how noisy an IMU is.
constexpr std::size_t kTimesSpent = 2, kFrameColumns = Column::kAccelNoise + 1 + kTimesSpent,
                      kFrameColumnsWithTest = Column::kGyroNoise + kTimesSpent,
                      kFrameColumnsOfOld = Column::kSigmaPixels + kTimesSpent;

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

constexpr std::array kUpdateStatuses = {UpdateStatus::kUpdated, UpdateStatus::kEmpty,
                                        UpdateStatus::kSingularInnovation};
constexpr std::array kInputStatuses = {InputStatus::kNotNeeded,    InputStatus::kSound,
                                       InputStatus::kFaulty,       InputStatus::kGap,
                                       InputStatus::kContradicted, InputStatus::kNone};

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

void write_frames_csv(const std::filesystem::path& path, const RunRecord& record) {
  std::string text = fmt::format("#{}\n", fmt::join(kFrameColumnNames, ","));
  auto out = std::back_inserter(text);
  for (std::size_t k = 0; k < record.frames.size(); ++k) {
    const FrameReport& f = record.frames[k];
    const auto& faults = f.inputs.faults.count;
    fmt::format_to(
        out,
        "{},{},{},{},{},{},{:d},{},{},{},{},{},{:.6g},{},{:d},{:.4g},{:.4g},{:.4g},{:.4g},{:.3f},{:.3f}\n",
        f.t_ns, f.observed, f.used, f.initialized, f.removed, f.refused.size(), f.gate_overruled, f.nis,
        f.dof, f.rank, to_string(f.status), to_string(f.inputs.status), f.inputs.gap_s,
        std::accumulate(faults.begin(), faults.end(), std::size_t{0}), f.reset, f.sigma_px, f.inputs.chi2,
        f.imu_noise.gyro, f.imu_noise.accel, record.frame_ms[k], record.source_ms[k]);
  }
  write_file_atomically(path, text);
}

std::vector<FrameRow> read_frames_csv(const std::filesystem::path& path) {
  detail::TableReader table(path, {.names = kFrameColumnNames,
                                   .counts = {kFrameColumnsOfOld, kFrameColumnsWithTest, kFrameColumns}});
  std::vector<FrameRow> rows;
  while (table.next()) {
    FrameRow row;
    row.t_ns = table.increasing_time();
    row.observed = count(table, Column::kObserved);
    row.used = count(table, Column::kUsed);
    row.initialized = count(table, Column::kInitialized);
    row.removed = count(table, Column::kRemoved);
    row.refused = count(table, Column::kRefused);
    row.gate_overruled = count(table, Column::kGateOverruled) != 0;
    row.nis = table.number(Column::kNis);
    row.dof = count(table, Column::kDof);
    row.rank = count(table, Column::kRank);
    row.status = one_of(kUpdateStatuses, table, Column::kStatus);
    row.inputs = one_of(kInputStatuses, table, Column::kInputs);
    row.gap_s = table.number(Column::kGap);
    row.reset = count(table, Column::kReset) != 0;
    if (table.columns() >= kFrameColumnsWithTest) {
      row.sigma_px = table.number(Column::kSigmaPixels);
      row.inputs_chi2 = table.number(Column::kInputsChi2);
    }
    if (table.columns() == kFrameColumns) {
      row.imu_noise = {table.number(Column::kGyroNoise), table.number(Column::kAccelNoise)};
    }
    row.filter_ms = table.number(table.columns() - 2);
    row.source_ms = table.number(table.columns() - 1);
    rows.push_back(row);
  }
  table.require_a_row("frame");
  return rows;
}

}  // namespace limber
