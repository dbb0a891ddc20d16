// SPDX-License-Identifier: MIT
#include "limber/run_files/frames_file.hpp"

#include "io/text_file.hpp"

namespace limber {
namespace {

std::size_t count(const detail::TableReader& table, std::size_t column) {
  const std::int64_t value = table.integer(column);
  if (value < 0) {
    table.fail("a count", std::to_string(value));
  }
  return static_cast<std::size_t>(value);
}

}  // namespace

std::vector<FrameRow> read_frames_csv(const std::filesystem::path& path) {
  detail::TableReader table(
      path, {.names = {"t_ns", "observed", "used", "initialized", "removed", "refused", "gate_overruled",
                       "nis [-]", "dof", "constrained_rank", "status", "inputs", "gap_s", "faulty_samples",
                       "reset", "filter_ms", "source_ms"},
             .counts = {17}});
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
    row.filter_ms = table.number(15);
    row.source_ms = table.number(16);
    rows.push_back(row);
  }
  table.require_a_row("frame");
  return rows;
}

}  // namespace limber
