// SPDX-License-Identifier: MIT
#include "limber/run_files/calibration_file.hpp"

#include <cstddef>
#include <string>

#include "io/table_text.hpp"
#include "io/text_file.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/io/parameter_text.hpp"

namespace limber {
namespace {

std::vector<std::string> calibration_columns() {
  std::vector<std::string> names = {"t_ns"};
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    const std::string name(kParameterNames[k]), unit = " [" + user_unit_of(k) + "]";
    names.push_back(name + unit);
    names.push_back("sigma_" + name + unit);
  }
  return names;
}

CalibrationRow calibration_row(detail::TableReader& table) {
  CalibrationRow out;
  out.t_ns = table.increasing_time();
  for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
    const std::size_t column = 1 + 2 * k;
    if (table.field(column).empty() && table.field(column + 1).empty()) {
      continue;
    }
    const auto at = static_cast<Eigen::Index>(k);
    const double unit = in_user_units(k, 1.0);
    out.estimate.parameters.set(k);
    out.estimate.error(at) = table.number(column) / unit;
    out.estimate.sigma(at) = table.number(column + 1) / unit;
  }
  return out;
}

}  // namespace

void write_calibration_csv(const std::filesystem::path& path, const std::vector<CalibrationRow>& rows) {
  detail::TableText table("calibration.csv", ',');
  table.header(detail::header_of(calibration_columns()));
  for (const CalibrationRow& row : rows) {
    table.time(row.t_ns);
    for (std::size_t k = 0; k < kParameterNames.size(); ++k) {
      if (!row.estimate.parameters[k]) {
        table.empty_cells(2);
        continue;
      }
      const auto at = static_cast<Eigen::Index>(k);
      table.cell(in_user_units(k, row.estimate.error(at)));
      table.cell(in_user_units(k, row.estimate.sigma(at)));
    }
    table.end_row();
  }
  write_file_atomically(path, table.text());
}

std::vector<CalibrationRow> read_calibration_csv(const std::filesystem::path& path) {
  const std::vector<std::string> names = calibration_columns();
  detail::TableReader table(path, {.names = {names.begin(), names.end()}, .counts = {names.size()}});
  std::vector<CalibrationRow> rows;
  while (table.next()) {
    rows.push_back(calibration_row(table));
  }
  table.require_a_row("frame");
  return rows;
}

}  // namespace limber
