// SPDX-License-Identifier: MIT
#include "schema.hpp"

#include <fmt/format.h>

#include <map>
#include <string>
#include <type_traits>

#include "check_content.hpp"
#include "figures_table.hpp"
#include "limber/core/errors.hpp"

namespace limber::detail {
namespace {

constexpr int kApplicationId = 0x6c696d62;  // "limb"

constexpr const char* kTables = R"sql(
CREATE TABLE study(seed INTEGER NOT NULL, program_version TEXT NOT NULL);
CREATE TABLE starts(
  time TEXT NOT NULL, program_version TEXT NOT NULL, compiler TEXT NOT NULL, cpu TEXT NOT NULL,
  host TEXT NOT NULL, processes INTEGER NOT NULL, threads INTEGER NOT NULL, shard TEXT NOT NULL);
CREATE TABLE cases(
  id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, runs INTEGER NOT NULL, start TEXT NOT NULL,
  scenario TEXT NOT NULL,  definition TEXT NOT NULL, definition_hash TEXT NOT NULL);
CREATE TABLE methods(
  case_id INTEGER NOT NULL, method INTEGER NOT NULL, label TEXT NOT NULL, PRIMARY KEY(case_id, method));
CREATE TABLE curves(
  case_id INTEGER NOT NULL, method INTEGER NOT NULL, quantity TEXT NOT NULL, unit TEXT NOT NULL,
  sums BLOB NOT NULL, PRIMARY KEY(case_id, method, quantity));
CREATE TABLE examples(
  case_id INTEGER NOT NULL, method INTEGER NOT NULL, positions BLOB NOT NULL, PRIMARY KEY(case_id, method));
)sql";

std::string joined_figures(const char* (*cell)(const char* name)) {
  std::string text;
  const RunFigures figures;
  visit_figures(figures, [&](const char* name, const auto&) {
    text += (text.empty() ? "" : ", ") + std::string(cell(name));
  });
  return text;
}

std::string runs_table() {
  std::string columns;
  const RunFigures figures;
  visit_figures(figures, [&](const char* name, const auto& figure) {
    using Value = typename std::decay_t<decltype(figure)>::value_type;
    columns += fmt::format(", {} {}", name, std::is_floating_point_v<Value> ? "REAL" : "INTEGER");
  });
  return "CREATE TABLE runs(case_id INTEGER NOT NULL, method INTEGER NOT NULL, run INTEGER NOT NULL, "
         "diverged_frame INTEGER, diverged_s REAL, diverged_reason TEXT" +
         columns + ", PRIMARY KEY(case_id, run, method)) WITHOUT ROWID;";
}

/// Tables, views, triggers and indices by name, each as its SQL; what SQLite keeps for itself is left out.
std::map<std::string, std::string> objects_of(const SqliteFile& file) {
  std::map<std::string, std::string> objects;
  SqliteStatement rows = file.prepare(
      "SELECT type || ' ' || name, sql FROM sqlite_master WHERE name NOT LIKE 'sqlite\\_%' ESCAPE '\\'");
  while (rows.step()) {
    std::string name;
    rows.get(name);
    rows.get(objects[name]);
  }
  return objects;
}

/// A view in place of a table, a trigger or another table's constraint may do anything: nothing but the
/// tables that create_schema makes is read or written.
void check_objects(const SqliteFile& file) {
  static const std::map<std::string, std::string> kExpected = [] {
    SqliteFile memory(":memory:", SqliteFile::Mode::kCreate, kStudyFile);
    create_schema(memory);
    return objects_of(memory);
  }();
  const std::map<std::string, std::string> found = objects_of(file);
  for (const auto& [name, sql] : found) {
    const auto expected = kExpected.find(name);
    if (expected == kExpected.end() || expected->second != sql) {
      throw DataError(file.path().string(), 0, "the tables of a study and nothing else",
                      fmt::format("the {}{}", name, expected == kExpected.end() ? "" : " of another form"));
    }
  }
  for (const auto& [name, sql] : kExpected) {
    if (!found.contains(name)) {
      throw DataError(file.path().string(), 0, fmt::format("the {} of a study", name), "none");
    }
  }
}

}  // namespace

bool is_empty(const SqliteFile& file) {
  return file.integer("SELECT count(*) FROM sqlite_master") == 0 &&
         file.integer("PRAGMA application_id") == 0;
}

void check_schema(const SqliteFile& file) {
  if (file.integer("PRAGMA application_id") != kApplicationId) {
    throw DataError(file.path().string(), 0, "a study of limber", "another SQLite database");
  }
  const std::int64_t version = file.integer("PRAGMA user_version");
  if (version != kSchemaVersion) {
    throw DataError(file.path().string(), 0, fmt::format("a study of version {}", kSchemaVersion),
                    fmt::format("one of version {}, which another version of limber made", version));
  }
  check_objects(file);
  check_content(file);
}

void create_schema(SqliteFile& file) {
  file.execute(
      fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {};", kApplicationId, kSchemaVersion));
  file.execute(kTables);
  file.execute(runs_table());
}

std::string figure_columns() {
  return joined_figures([](const char* name) { return name; });
}

std::string figure_placeholders() {
  return joined_figures([](const char*) { return "?"; });
}

std::string run_columns() { return "run, diverged_frame, diverged_s, diverged_reason, " + figure_columns(); }

void put_run(SqliteStatement& statement, const StudyRun& run) {
  statement.put(run.run);
  if (run.diverged) {
    statement.put(run.diverged->frame).put(run.diverged->t).put(run.diverged->reason);
  } else {
    statement.put_null().put_null().put_null();
  }
  visit_figures(run.figures, [&](const char*, const auto& figure) { statement.put(figure); });
}

StudyRun get_run(SqliteStatement& statement) {
  StudyRun run;
  statement.get(run.run);
  std::optional<std::uint64_t> frame;
  Divergence divergence;
  statement.get(frame);
  statement.get(divergence.t);
  statement.get(divergence.reason);
  if (frame) {
    divergence.frame = *frame;
    run.diverged = divergence;
  }
  visit_figures(run.figures, [&](const char*, auto& figure) { statement.get(figure); });
  return run;
}

}  // namespace limber::detail
