// SPDX-License-Identifier: MIT
#include "limber/study/merge_studies.hpp"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <system_error>

#include "limber/core/errors.hpp"
#include "limber/io/atomic_file.hpp"
#include "limber/study/study_database.hpp"
#include "schema.hpp"
#include "study_store.hpp"

namespace limber {
namespace {

using detail::SqliteFile;
using detail::SqliteStatement;
using detail::SqliteTransaction;

/// A case of a part.
struct PartCase {
  std::int64_t id = 0;
  std::uint64_t runs = 0;
  std::string name, definition;
};

class Merger {
 public:
  explicit Merger(const std::filesystem::path& out)
      : out_(out, SqliteFile::Mode::kCreate, detail::kStudyFile), transaction_(out_) {
    detail::create_schema(out_);
  }

  void add(const std::filesystem::path& path) {
    const SqliteFile part(path, SqliteFile::Mode::kRead, detail::kStudyFile);
    detail::check_schema(part);
    add_study(part);
    copy(part, "SELECT * FROM starts", "INSERT INTO starts VALUES(?, ?, ?, ?, ?, ?, ?, ?)", std::nullopt);
    SqliteStatement cases = part.prepare("SELECT id, runs, name, definition FROM cases ORDER BY id");
    while (cases.step()) {
      PartCase from;
      cases.get(from.id);
      cases.get(from.runs);
      cases.get(from.name);
      cases.get(from.definition);
      add_runs(part, from, case_like(part, from));
    }
  }

  void commit() { transaction_.commit(); }

 private:
  void add_study(const SqliteFile& part) {
    const std::int64_t seed = part.integer("SELECT seed FROM study");
    if (out_.integer("SELECT count(*) FROM study") == 0) {
      copy(part, "SELECT seed, program_version FROM study", "INSERT INTO study VALUES(?, ?)", std::nullopt);
    } else if (const std::int64_t other = out_.integer("SELECT seed FROM study"); other != seed) {
      throw std::runtime_error(fmt::format("{} was made with seed {}, the parts before it with {}",
                                           part.path().string(), seed, other));
    }
  }

  /// The number in the output of the case that has the same definition, made if needed.
  std::int64_t case_like(const SqliteFile& part, const PartCase& from) {
    SqliteStatement there = out_.prepare("SELECT id, definition FROM cases WHERE name = ?");
    there.put(from.name);
    if (!there.step()) {
      copy(part,
           fmt::format(
               "SELECT name, runs, start, scenario, definition, definition_hash FROM cases WHERE id = {}",
               from.id),
           "INSERT INTO cases(name, runs, start, scenario, definition, definition_hash) VALUES(?, ?, ?, ?, "
           "?, ?)",
           std::nullopt);
      const std::int64_t id = out_.integer("SELECT last_insert_rowid()");
      copy(part, fmt::format("SELECT method, label FROM methods WHERE case_id = {}", from.id),
           "INSERT INTO methods VALUES(?, ?, ?)", id);
      return id;
    }
    const auto id = there.get<std::int64_t>();
    std::string definition;
    there.get(definition);
    if (definition != from.definition) {
      throw std::runtime_error(fmt::format("{} holds '{}' with other settings than the parts before it:\n{}",
                                           part.path().string(), from.name,
                                           detail::differing_lines(definition, from.definition)));
    }
    out_.prepare("UPDATE cases SET runs = max(runs, ?) WHERE id = ?").put(from.runs).put(id).run();
    return id;
  }

  void add_runs(const SqliteFile& part, const PartCase& from, std::int64_t id) {
    refuse_common_runs(part, from, id);
    const std::string columns = "method, " + detail::run_columns();
    copy(part, fmt::format("SELECT {} FROM runs WHERE case_id = {}", columns, from.id),
         fmt::format("INSERT INTO runs(case_id, {}) VALUES(?, ?, ?, ?, ?, ?, {})", columns,
                     detail::figure_placeholders()),
         id);
    copy(part, fmt::format("SELECT method, positions FROM examples WHERE case_id = {}", from.id),
         "INSERT INTO examples VALUES(?, ?, ?)", id);
    SqliteStatement curves = part.prepare("SELECT method, quantity, sums FROM curves WHERE case_id = ?");
    curves.put(from.id);
    while (curves.step()) {
      add_sums(curves, id);
    }
  }

  void refuse_common_runs(const SqliteFile& part, const PartCase& from, std::int64_t id) {
    SqliteStatement runs = part.prepare("SELECT run FROM runs WHERE case_id = ? AND method = 0 ORDER BY run");
    runs.put(from.id);
    while (runs.step()) {
      const auto run = runs.get<std::uint64_t>();
      SqliteStatement there = out_.prepare("SELECT 1 FROM runs WHERE case_id = ? AND run = ? LIMIT 1");
      there.put(id).put(run);
      if (there.step()) {
        throw std::runtime_error(fmt::format("{} holds run {} of '{}', and so does a part before it",
                                             part.path().string(), run, from.name));
      }
    }
  }

  void add_sums(SqliteStatement& row, std::int64_t id) {
    const auto method = row.get<std::size_t>();
    std::string name;
    row.get(name);
    const std::string_view bytes = row.get_bytes();
    detail::add_to_curve(out_, id, method, quantity_from_name(name),
                         CurveSum(quantity_from_name(name), bytes));
  }

  /// Rows of the part into the output, as they are; `first`, if any, goes before their columns.
  void copy(const SqliteFile& part, const std::string& select, const std::string& insert,
            const std::optional<std::int64_t>& first) {
    SqliteStatement rows = part.prepare(select), into = out_.prepare(insert);
    while (rows.step()) {
      if (first) {
        into.put(*first);
      }
      into.put_row(rows);
      into.run();
    }
  }

  SqliteFile out_;
  SqliteTransaction transaction_;
};

/// Every curve of a part can be read.
void check_part(const std::filesystem::path& part) {
  const StudyDatabase study(part);
  for (std::size_t c = 0; c < study.info().cases.size(); ++c) {
    for (std::size_t m = 0; m < study.info().cases[c].methods.size(); ++m) {
      for (std::size_t q = 0; q < kCurveQuantities; ++q) {
        (void)study.curve(c, m, static_cast<CurveQuantity>(q));
      }
    }
  }
}

}  // namespace

void merge_studies(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& out) {
  if (std::filesystem::exists(out)) {
    throw DataError(out.string(), 0, "a name that is not taken", "a file");
  }
  try {
    Temporary temporary(out, Temporary::Kind::kFile);
    Merger merger(temporary.path());
    for (const std::filesystem::path& part : parts) {
      check_part(part);
      merger.add(part);
    }
    merger.commit();
    std::filesystem::rename(temporary.path(), out);
    temporary.release();
  } catch (const std::filesystem::filesystem_error& error) {
    throw DataError(out.string(), 0, "a place where a database can be made", error.code().message());
  }
}

}  // namespace limber
