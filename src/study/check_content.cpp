// SPDX-License-Identifier: MIT
#include "check_content.hpp"

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "figures_table.hpp"
#include "limber/core/errors.hpp"
#include "limber/study/curve.hpp"
#include "limber/study/exact_sum.hpp"

namespace limber::detail {
namespace {

/// Where `broken` (SQL) holds the column is not what is expected of it.
struct Rule {
  std::string column, broken, expected;
};

/// @param row  SQL that says in words which row it is
struct Table {
  std::string name, row;
  std::vector<Rule> rules;
};

constexpr const char* kOfMethod = "'case ' || case_id || ', method ' || method";

const char* in_words(const std::string& type) {
  return type == "integer" ? "an integer" : type == "real" ? "a number" : type == "text" ? "text" : "bytes";
}

/// SQLite keeps any value in any column.
std::vector<Rule> type_rules(const SqliteFile& file, const std::string& table) {
  std::vector<Rule> rules;
  SqliteStatement columns =
      file.prepare("SELECT name, lower(type), \"notnull\" OR pk FROM pragma_table_info(?)");
  columns.put(table);
  while (columns.step()) {
    std::string name, type;
    columns.get(name);
    columns.get(type);
    const bool is_needed = columns.get<bool>();
    rules.push_back({name,
                     fmt::format("typeof({0}) <> '{1}'{2}", name, type,
                                 is_needed ? "" : fmt::format(" AND {} IS NOT NULL", name)),
                     in_words(type) + std::string(is_needed ? "" : " or nothing")});
  }
  return rules;
}

std::vector<Rule> rules_of_cases() {
  return {{"runs", fmt::format("runs NOT BETWEEN 1 AND {}", kMaxTerms),
           fmt::format("at least one and at most {} runs", kMaxTerms)},
          {"name", "NOT EXISTS(SELECT 1 FROM methods WHERE case_id = id)", "at least one method of a case"}};
}

/// Of every table with a case and a method but `methods` itself.
Rule rule_of_reference(const std::string& table) {
  return {"method",
          fmt::format("NOT EXISTS(SELECT 1 FROM methods AS m WHERE m.case_id = {0}.case_id AND m.method = "
                      "{0}.method)",
                      table),
          "a case and a method of the table methods"};
}

/// Those that every run has which did not diverge.
constexpr std::array kPoseCurves = {CurveQuantity::kPositionSquaredError,
                                    CurveQuantity::kPositionVariance,
                                    CurveQuantity::kAttitudeSquaredError,
                                    CurveQuantity::kAttitudeVariance,
                                    CurveQuantity::kPoseNees,
                                    CurveQuantity::kPositionNees,
                                    CurveQuantity::kAttitudeNees};

std::vector<Rule> rules_of_methods() {
  std::string names;
  for (const CurveQuantity quantity : kPoseCurves) {
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", name_of(quantity));
  }
  return {{"case_id", "NOT EXISTS(SELECT 1 FROM cases WHERE id = case_id)", "a case of the table cases"},
          {"method",
           "method NOT BETWEEN 0 AND (SELECT count(*) FROM methods AS m WHERE m.case_id = methods.case_id) - "
           "1",
           "methods numbered from 0"},
          {"label",
           fmt::format("EXISTS(SELECT 1 FROM runs AS r WHERE r.case_id = methods.case_id AND r.method = "
                       "methods.method AND r.diverged_frame IS NULL) AND (SELECT count(*) FROM curves AS c "
                       "WHERE c.case_id = methods.case_id AND c.method = methods.method AND c.quantity IN "
                       "({})) < {}",
                       names, kPoseCurves.size()),
           "curves of pose errors, variances and NEES in the table curves"}};
}

std::vector<Rule> rules_of_curves() {
  std::string known;
  for (std::size_t k = 0; k < kCurveQuantities; ++k) {
    const auto quantity = static_cast<CurveQuantity>(k);
    known += fmt::format("{}'{} {}'", k == 0 ? "" : ", ", name_of(quantity), unit_of(quantity));
  }
  return {rule_of_reference("curves"),
          {"quantity", fmt::format("quantity || ' ' || unit NOT IN ({})", known),
           "a quantity of a study in its unit"}};
}

std::vector<Rule> rules_of_examples() {
  const std::string first_run =
      "SELECT 1 FROM runs AS r WHERE r.case_id = examples.case_id AND r.run = 0 AND r.method = "
      "examples.method";
  return {rule_of_reference("examples"),
          {"method", fmt::format("NOT EXISTS({})", first_run), "a path of a run 0 of the table runs"},
          {"length(positions)",
           fmt::format("length(positions) % {0} <> 0 OR length(positions) = 0 AND EXISTS({1} AND "
                       "r.diverged_frame IS NULL)",
                       3 * sizeof(double), first_run),
           fmt::format("{} bytes for each frame of run 0", 3 * sizeof(double))}};
}

std::vector<Rule> rules_of_runs() {
  std::vector<Rule> rules = {
      rule_of_reference("runs"),
      {"run", "run NOT BETWEEN 0 AND (SELECT cases.runs FROM cases WHERE id = case_id) - 1",
       "no more finished than planned"},
      {"run",
       "(SELECT count(*) FROM runs AS r WHERE r.case_id = runs.case_id AND r.run = runs.run) <> (SELECT "
       "count(*) FROM methods AS m WHERE m.case_id = runs.case_id)",
       "every run with each method of its case"},
      {"run",
       "run = 0 AND NOT EXISTS(SELECT 1 FROM examples AS e WHERE e.case_id = runs.case_id AND e.method = "
       "runs.method)",
       "a path of run 0 in the table examples"},
      {"diverged_frame",
       "(diverged_frame IS NULL) + (diverged_s IS NULL) + (diverged_reason IS NULL) NOT IN (0, 3)",
       "frame, time and reason of a divergence, or none of them"},
      {"share_within_95", "share_within_95 > 1", "a share, at most 1"}};
  for (const char* const name : {"diverged_frame", "diverged_s"}) {
    rules.push_back({name, fmt::format("{} < 0", name), "a number that is not negative"});
  }
  const RunFigures figures;
  visit_figures(figures, [&](const char* name, const auto&) {
    rules.push_back({name, fmt::format("{} < 0", name), "a number that is not negative"});
  });
  return rules;
}

/// The first row that breaks a rule; of its rules the first.
void check_rules(const SqliteFile& file, const Table& table) {
  std::string any, which, value;
  for (std::size_t k = 0; k < table.rules.size(); ++k) {
    const Rule& rule = table.rules[k];
    any += fmt::format("{}({})", k == 0 ? "" : " OR ", rule.broken);
    which += fmt::format(" WHEN {} THEN {}", rule.broken, k);
    value += fmt::format(" WHEN {} THEN substr(quote({}), 1, 60)", rule.broken, rule.column);
  }
  SqliteStatement broken =
      file.prepare(fmt::format("SELECT CASE{} END, CASE{} END, {} FROM {} WHERE {} LIMIT 1", which, value,
                               table.row, table.name, any));
  if (broken.step()) {
    const Rule& rule = table.rules.at(broken.get<std::size_t>());
    std::string found, row;
    broken.get(found);
    broken.get(row);
    throw DataError(file.path().string(), 0, fmt::format("the table {} with {}", table.name, rule.expected),
                    fmt::format("{} {} ({})", rule.column, found, row));
  }
}

}  // namespace

void check_content(const SqliteFile& file) {
  const std::vector<Table> tables = {
      {"study", "'its row ' || rowid", {}},
      {"starts", "'its row ' || rowid", {}},
      {"cases", "'case ' || id", rules_of_cases()},
      {"methods", kOfMethod, rules_of_methods()},
      {"runs", std::string(kOfMethod) + " || ', run ' || run", rules_of_runs()},
      {"curves", std::string(kOfMethod) + " || ', ' || quantity", rules_of_curves()},
      {"examples", kOfMethod, rules_of_examples()}};
  for (const Table& table : tables) {  // types of all first: further rules compare
    check_rules(file, {table.name, table.row, type_rules(file, table.name)});
  }
  if (const std::int64_t rows = file.integer("SELECT count(*) FROM study"); rows != 1) {
    throw DataError(file.path().string(), 0, "one row in the table study", fmt::format("{} rows", rows));
  }
  for (const Table& table : tables) {
    if (!table.rules.empty()) {
      check_rules(file, table);
    }
  }
}

}  // namespace limber::detail
