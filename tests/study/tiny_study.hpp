// SPDX-License-Identifier: MIT
#pragma once

#include <sqlite3.h>

#include <filesystem>
#include <string>
#include <vector>

#include "limber/simulate/scenario_file.hpp"
#include "limber/study/run_study.hpp"

namespace limber::testing {

/// One second of the paper's case (ii) among few points: milliseconds per run.
inline Scenario tiny_scenario(const std::string& name = "tiny") {
  Scenario scenario;
  scenario.name = name;
  scenario.duration = 1.0;
  scenario.world.points = 60;
  scenario.decalibration = {{paper_decalibration(), ConstantShape{}}};
  return scenario;
}

/// A walk of theta that no arithmetic survives.
inline const std::string kHopeless = "ekf-full:walk=1e+300/1e+300";

inline StudyPlan tiny_plan(std::uint64_t runs, const std::string& methods = "ekf,ekf-full,lcekf") {
  StudyPlan plan;
  plan.cases.push_back(
      {tiny_scenario(), method_variants_from_string(methods), runs, StartMode::kGroundTruth});
  return plan;
}

/// Two cases, the second without IMU and with fewer runs.
inline StudyPlan two_cases(std::uint64_t runs) {
  StudyPlan plan = tiny_plan(runs, "ekf,ekf-full,lcekf," + kHopeless);
  Scenario vision = tiny_scenario("tiny_vision");
  vision.use_imu = false;
  plan.cases.push_back(
      {vision, method_variants_from_string("lcekf:full,mono-left"), (runs + 1) / 2, StartMode::kGroundTruth});
  return plan;
}

/// The rows of a query, cells with '|' between them; bytes in hexadecimal. Doubles to their last bit.
inline std::vector<std::string> rows_of(const std::filesystem::path& database, const std::string& sql) {
  sqlite3* handle = nullptr;
  sqlite3_stmt* statement = nullptr;
  std::vector<std::string> rows;
  if (sqlite3_open_v2(database.c_str(), &handle, SQLITE_OPEN_READWRITE, nullptr) == SQLITE_OK &&
      sqlite3_busy_timeout(handle, 10'000) == SQLITE_OK &&  // a writer may hold the file just now
      sqlite3_prepare_v2(handle, sql.c_str(), -1, &statement, nullptr) == SQLITE_OK) {
    while (sqlite3_step(statement) == SQLITE_ROW) {
      std::string row;
      for (int k = 0; k < sqlite3_column_count(statement); ++k) {
        const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(statement, k));
        row += (k > 0 ? "|" : "") + std::string(text == nullptr ? "NULL" : text);
      }
      rows.push_back(row);
    }
  } else {
    rows.emplace_back(sqlite3_errmsg(handle));
  }
  sqlite3_finalize(statement);
  sqlite3_close(handle);
  return rows;
}

/// Columns of `runs` but for the case and timings, each as SQL that keeps every bit.
inline std::string repeatable_columns(const std::filesystem::path& database) {
  std::string columns;
  for (const std::string& name :
       rows_of(database,
               "SELECT name FROM pragma_table_info('runs') WHERE name NOT LIKE 'ms_%' AND name <> "
               "'case_id' AND name <> 'method' AND name <> 'run'")) {
    columns +=
        ", CASE typeof(" + name + ") WHEN 'real' THEN printf('%!.17g', " + name + ") ELSE " + name + " END";
  }
  return columns;
}

/// Everything in a study that has to be repeatable: all but the table of starts, timings, and the order of
/// rows.
inline std::vector<std::string> content_of(const std::filesystem::path& database) {
  const std::string name = "(SELECT name FROM cases WHERE id = case_id), ";
  std::vector<std::string> content;
  for (const std::string& sql :
       {std::string("SELECT seed, program_version FROM study"),
        std::string(
            "SELECT name, runs, start, scenario, definition, definition_hash FROM cases ORDER BY name"),
        "SELECT " + name + "method, label FROM methods ORDER BY 1, 2",
        "SELECT " + name + "method, run" + repeatable_columns(database) + " FROM runs ORDER BY 1, 2, 3",
        "SELECT " + name + "method, quantity, unit, hex(sums) FROM curves ORDER BY 1, 2, 3",
        "SELECT " + name + "method, hex(positions) FROM examples ORDER BY 1, 2"}) {
    for (const std::string& row : rows_of(database, sql)) {
      content.push_back(row);
    }
    content.emplace_back("--");
  }
  return content;
}

}  // namespace limber::testing
