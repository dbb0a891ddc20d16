// SPDX-License-Identifier: MIT
#include "study_store.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

#include "bytes.hpp"
#include "figures_table.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/random.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "schema.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kMostLines = 8;  // of a difference that a message shows

std::multiset<std::string> lines_of(const std::string& text) {
  std::multiset<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    lines.insert(line);
  }
  return lines;
}

std::string lines_missing(const std::string& from, const std::string& in, const char* mark) {
  std::multiset<std::string> others = lines_of(in);
  std::string text;
  std::size_t count = 0;
  std::istringstream stream(from);
  for (std::string line; std::getline(stream, line);) {
    if (const auto found = others.find(line); found != others.end()) {
      others.erase(found);
    } else if (++count <= kMostLines) {
      text += fmt::format("  {} {}\n", mark, line);
    }
  }
  return count > kMostLines ? text + fmt::format("  {} and {} more\n", mark, count - kMostLines) : text;
}

std::string cpu_name() {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("model name")) {
      return line.substr(std::min(line.size(), line.find(':') + 2));
    }
  }
  return "unknown";
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

void record_start(const SqliteFile& file, const StartRecord& start) {
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  file.prepare("INSERT INTO starts VALUES(?, ?, ?, ?, ?, ?, ?, ?)")
      .put(fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now)))
      .put(start.program_version)
      .put(std::string_view(__VERSION__))
      .put(cpu_name())
      .put(host_name())
      .put(start.processes)
      .put(start.threads)
      .put(start.shard)
      .run();
}

/// Whether two runs have the same bits, timings apart.
bool same(const StudyRun& a, const StudyRun& b, std::string& what) {
  const auto state = [](const StudyRun& run) {
    return run.diverged ? fmt::format("diverged at frame {}", run.diverged->frame) : "did not diverge";
  };
  if (state(a) != state(b)) {
    what = state(a) + ", now " + state(b);
    return false;
  }
  std::vector<std::pair<std::string, std::string>> cells;
  visit_figures(a.figures, [&](const char* name, const auto& figure) {
    cells.emplace_back(name, figure ? fmt::format("{}", *figure) : "unknown");
  });
  std::size_t k = 0;
  visit_figures(b.figures, [&](const char*, const auto& figure) {
    auto& [name, cell] = cells[k++];
    const std::string other = figure ? fmt::format("{}", *figure) : "unknown";
    if (what.empty() && !name.starts_with("ms_") && cell != other) {
      what = fmt::format("{} {}, now {}", name, cell, other);
    }
  });
  return what.empty();
}

std::string positions_bytes(const std::vector<Eigen::Vector3d>& positions) {
  ByteWriter out;
  for (const Eigen::Vector3d& p : positions) {
    out.put(p.x());
    out.put(p.y());
    out.put(p.z());
  }
  return out.take();
}

}  // namespace

std::string differing_lines(const std::string& stored, const std::string& asked) {
  return lines_missing(stored, asked, "stored:") + lines_missing(asked, stored, "now:   ");
}

void add_to_curve(const SqliteFile& file, std::int64_t case_id, std::size_t method, CurveQuantity quantity,
                  const CurveSum& terms) {
  SqliteStatement stored =
      file.prepare("SELECT sums FROM curves WHERE case_id = ? AND method = ? AND quantity = ?");
  stored.put(case_id).put(method).put(name_of(quantity));
  CurveSum sum = terms;
  if (stored.step()) {
    try {
      sum.add(CurveSum(quantity, stored.get_bytes()));
    } catch (const std::invalid_argument& error) {
      throw DataError(file.path().string(), 0, fmt::format("sums of every frame in {}", name_of(quantity)),
                      error.what());
    }
  }
  file.prepare("INSERT OR REPLACE INTO curves VALUES(?, ?, ?, ?, ?)")
      .put(case_id)
      .put(method)
      .put(name_of(quantity))
      .put(unit_of(quantity))
      .put_bytes(sum.to_bytes())
      .run();
}

StudyStore::StudyStore(const std::filesystem::path& path, const StudyPlan& plan, const StartRecord& start)
    : file_(path, SqliteFile::Mode::kCreate, kStudyFile) {
  SqliteTransaction transaction(file_);
  if (is_empty(file_)) {
    create_schema(file_);
    file_.prepare("INSERT INTO study VALUES(?, ?)").put(plan.seed).put(start.program_version).run();
  }
  check_schema(file_);
  take_up(plan, start);
  transaction.commit();
}

void StudyStore::take_up(const StudyPlan& plan, const StartRecord& start) {
  const auto seed = static_cast<std::uint64_t>(file_.integer("SELECT seed FROM study"));
  if (seed != plan.seed) {
    throw std::runtime_error(fmt::format("{} was begun with seed {}, not {}; use another --out, or --seed {}",
                                         file_.path().string(), seed, plan.seed, seed));
  }
  for (std::size_t k = 0; k < plan.cases.size(); ++k) {
    take_up_case(k, plan.cases[k]);
  }
  record_start(file_, start);
}

void StudyStore::add_case(const StudyCase& study_case, const std::string& definition) {
  file_
      .prepare(
          "INSERT INTO cases(name, runs, start, scenario, definition, definition_hash) VALUES(?, ?, ?, ?, ?, "
          "?)")
      .put(study_case.scenario.name)
      .put(study_case.runs)
      .put(name_of(study_case.start))
      .put(format_scenario(study_case.scenario))
      .put(definition)
      .put(fmt::format("{:016x}", fnv1a(definition)))
      .run();
  const auto id = file_.integer("SELECT last_insert_rowid()");
  for (std::size_t k = 0; k < study_case.methods.size(); ++k) {
    file_.prepare("INSERT INTO methods VALUES(?, ?, ?)")
        .put(id)
        .put(k)
        .put(to_string(study_case.methods[k]))
        .run();
  }
}

void StudyStore::take_up_case(std::size_t index, const StudyCase& study_case) {
  const std::string& name = study_case.scenario.name;
  const std::string definition = definition_of(study_case);
  SqliteStatement stored = file_.prepare("SELECT id, runs, definition FROM cases WHERE name = ?");
  stored.put(name);
  if (!stored.step()) {
    add_case(study_case, definition);
    stored.reset();
    stored.put(name);
    stored.step();
  }
  ids_.push_back(stored.get<std::int64_t>());
  const auto runs = stored.get<std::uint64_t>();
  std::string text;
  stored.get(text);
  if (text != definition) {
    throw std::runtime_error(fmt::format(
        "{} holds '{}' with other settings than these:\n{}use another --out, or give the scenario another "
        "'name:'",
        file_.path().string(), name, differing_lines(text, definition)));
  }
  if (runs < study_case.runs) {
    file_.prepare("UPDATE cases SET runs = ? WHERE id = ?").put(study_case.runs).put(ids_.back()).run();
  }
  frames_.push_back(frame_times(study_case.scenario).size());
  finished_.emplace_back(std::max(runs, study_case.runs), false);
  load_finished(index);
}

void StudyStore::load_finished(std::size_t index) {
  SqliteStatement rows = file_.prepare("SELECT run FROM runs WHERE case_id = ? AND method = 0");
  rows.put(ids_[index]);
  while (rows.step()) {
    finished_[index][rows.get<std::uint64_t>()] = true;
  }
}

bool StudyStore::is_finished(std::size_t study_case, std::uint64_t run) const {
  return finished_.at(study_case).at(run);
}

void StudyStore::save(const ItemResult& result) {
  SqliteTransaction transaction(file_);
  SqliteStatement present = file_.prepare("SELECT 1 FROM runs WHERE case_id = ? AND run = ? LIMIT 1");
  present.put(ids_.at(result.study_case)).put(result.run);
  if (!present.step()) {
    for (std::size_t method = 0; method < result.methods.size(); ++method) {
      save_method(result, method);
    }
  }
  present.reset();
  transaction.commit();
  finished_[result.study_case].at(result.run) = true;
}

void StudyStore::save_method(const ItemResult& result, std::size_t method) {
  const std::int64_t id = ids_[result.study_case];
  const MethodResult& what = result.methods[method];
  SqliteStatement insert = file_.prepare("INSERT INTO runs(case_id, method, " + run_columns() +
                                         ") VALUES(?, ?, ?, ?, ?, ?, " + figure_placeholders() + ")");
  insert.put(id).put(method);
  put_run(insert, what.run);
  insert.run();
  const std::size_t frames = frames_[result.study_case];
  for (const RunSeries& series : what.series) {
    CurveSum terms(series.quantity, frames);
    terms.add(series.values);
    add_to_curve(file_, id, method, series.quantity, terms);
  }
  if (result.run == 0) {
    file_.prepare("INSERT INTO examples VALUES(?, ?, ?)")
        .put(id)
        .put(method)
        .put_bytes(positions_bytes(what.positions))
        .run();
  }
}

void StudyStore::compare(const ItemResult& result) const {
  SqliteStatement rows = file_.prepare("SELECT method, " + run_columns() +
                                       " FROM runs WHERE case_id = ? AND run = ? ORDER BY method");
  rows.put(ids_.at(result.study_case)).put(result.run);
  while (rows.step()) {
    const auto method = rows.get<std::size_t>();
    std::string what;
    if (!same(get_run(rows), result.methods.at(method).run, what)) {
      SqliteStatement name = file_.prepare("SELECT name FROM cases WHERE id = ?");
      name.put(ids_[result.study_case]).step();
      throw std::runtime_error(fmt::format(
          "{} was begun by another program or processor, and this one computes other numbers: {}, run {}, "
          "method {}: {}; use another --out",
          file_.path().string(), name.get_bytes(), result.run, method, what));
    }
  }
}

}  // namespace limber::detail
