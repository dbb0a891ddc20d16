// SPDX-License-Identifier: MIT
#include "limber/study/study_database.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "bytes.hpp"
#include "definition_text.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/random.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"
#include "limber/study/exact_sum.hpp"
#include "limber/study/study_plan.hpp"
#include "schema.hpp"

namespace limber {
namespace {

using detail::SqliteFile;
using detail::SqliteStatement;

constexpr std::size_t kBytesPerPosition = 3 * sizeof(double);

std::vector<std::string> labels_of(const SqliteFile& file, std::int64_t id) {
  std::vector<std::string> labels;
  SqliteStatement rows = file.prepare("SELECT label FROM methods WHERE case_id = ? ORDER BY method");
  rows.put(id);
  while (rows.step()) {
    rows.get(labels.emplace_back());
  }
  return labels;
}

/// A definition has the content of a trajectory file in place of its path.
std::string without_path(const std::string& text) {
  const std::size_t begin = text.find("\n  path: ");
  return begin == std::string::npos ? text : text.substr(0, begin) + text.substr(text.find('\n', begin + 1));
}

std::vector<Eigen::Vector3d> positions_from(std::string_view bytes) {
  std::vector<Eigen::Vector3d> positions;
  detail::ByteReader in(bytes);
  for (std::size_t n = bytes.size() / kBytesPerPosition; n > 0; --n) {
    const auto x = in.get<double>(), y = in.get<double>(), z = in.get<double>();
    positions.emplace_back(x, y, z);
  }
  return positions;
}

}  // namespace

class StudyDatabase::Impl {
 public:
  explicit Impl(const std::filesystem::path& path)
      : file_(path, SqliteFile::Mode::kRead, detail::kStudyFile) {
    detail::check_schema(file_);
    SqliteStatement study = file_.prepare("SELECT program_version, seed FROM study");
    study.step();
    study.get(info_.program_version);
    study.get(info_.seed);
    SqliteStatement rows = file_.prepare(
        "SELECT id, name, runs, start, scenario, (SELECT count(*) FROM runs WHERE case_id = id AND method = "
        "0), definition, definition_hash FROM cases ORDER BY id");
    while (rows.step()) {
      add_case(rows);
    }
  }

  [[nodiscard]] const StudyInfo& info() const { return info_; }
  [[nodiscard]] const SqliteFile& file() const { return file_; }

  /// The number of a case in the database; checks the indices.
  [[nodiscard]] std::int64_t id_of(std::size_t study_case, std::size_t method) const {
    if (study_case >= ids_.size() || method >= info_.cases[study_case].methods.size()) {
      throw std::invalid_argument(fmt::format("study: no method {} of a case {}", method, study_case));
    }
    return ids_[study_case];
  }

  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw DataError(file_.path().string(), 0, expected, found);
  }

 private:
  void add_case(SqliteStatement& row) {
    StudyCaseInfo info;
    row.get(ids_.emplace_back());
    row.get(info.name);
    row.get(info.runs);
    std::string start;
    row.get(start);
    row.get(info.scenario_text);
    row.get(info.finished);
    std::string definition, hash;
    row.get(definition);
    row.get(hash);
    try {
      info.start = start_mode_from_string(start);
    } catch (const std::invalid_argument& error) {
      fail(fmt::format("a start of '{}' that this version knows", info.name), error.what());
    }
    info.scenario = parse_scenario(info.scenario_text, file_.path());
    info.labels = labels_of(file_, ids_.back());
    for (const std::string& label : info.labels) {
      try {
        info.methods.push_back(method_variant_from_string(label));
      } catch (const std::invalid_argument& error) {
        fail(fmt::format("methods of '{}' that this version knows", info.name), error.what());
      }
    }
    check_definition(info, definition, hash);
    info.frame_times = frame_times(info.scenario);
    info_.cases.push_back(std::move(info));
  }

  /// Runs are of the scenario and the methods that the definition has, or they were changed since.
  void check_definition(const StudyCaseInfo& info, const std::string& definition,
                        const std::string& hash) const {
    const std::string expected = fmt::format("{:016x}", fnv1a(definition));
    if (hash != expected) {
      fail(fmt::format("the hash {} of the definition of '{}' in the table cases", expected, info.name),
           hash);
    }
    const bool has_file = std::holds_alternative<FileTrajectory>(info.scenario.trajectory);
    const std::string made_of = detail::definition_text(info.scenario_text, info.start, info.labels);
    if (has_file ? without_path(definition) != without_path(made_of) : definition != made_of) {
      fail(fmt::format("the scenario, start and methods of '{}' as its definition in the table cases",
                       info.name),
           "another one");
    }
  }

  SqliteFile file_;
  StudyInfo info_;
  std::vector<std::int64_t> ids_;
};

StudyDatabase::StudyDatabase(const std::filesystem::path& path) : impl_(std::make_unique<Impl>(path)) {}
StudyDatabase::~StudyDatabase() = default;
StudyDatabase::StudyDatabase(StudyDatabase&&) noexcept = default;
StudyDatabase& StudyDatabase::operator=(StudyDatabase&&) noexcept = default;

const StudyInfo& StudyDatabase::info() const { return impl_->info(); }

std::vector<StudyRun> StudyDatabase::runs(std::size_t study_case, std::size_t method) const {
  SqliteStatement rows = impl_->file().prepare("SELECT " + detail::run_columns() +
                                               " FROM runs WHERE case_id = ? AND method = ? ORDER BY run");
  rows.put(impl_->id_of(study_case, method)).put(method);
  std::vector<StudyRun> runs;
  while (rows.step()) {
    runs.push_back(detail::get_run(rows));
  }
  return runs;
}

std::optional<StudyCurve> StudyDatabase::curve(std::size_t study_case, std::size_t method,
                                               CurveQuantity quantity) const {
  SqliteStatement row =
      impl_->file().prepare("SELECT sums FROM curves WHERE case_id = ? AND method = ? AND quantity = ?");
  row.put(impl_->id_of(study_case, method)).put(method).put(name_of(quantity));
  if (!row.step()) {
    return std::nullopt;
  }
  const StudyCaseInfo& info = this->info().cases[study_case];
  const std::string_view bytes = row.get_bytes();
  if (bytes.size() != kBytesPerFrame * info.frame_times.size()) {
    impl_->fail(
        fmt::format("sums of the {} frames of '{}' in the curve {}", info.frame_times.size(), info.name,
                    name_of(quantity)),
        fmt::format("{} bytes instead of {}", bytes.size(), kBytesPerFrame * info.frame_times.size()));
  }
  return CurveSum(quantity, bytes).curve();
}

ExampleRun StudyDatabase::example(std::size_t study_case) const {
  static_cast<void>(impl_->id_of(study_case, 0));
  const StudyCaseInfo& info = this->info().cases[study_case];
  const Recording recording = simulate(info.scenario, this->info().seed, 0);
  ExampleRun out;
  for (const StereoFrame& frame : recording.frames) {
    out.truth.push_back(groundtruth_at(recording.truth.motion.states, frame.t_ns)->p_world_body);
  }
  for (const auto& [id, p_world_landmark] : recording.truth.landmarks) {
    out.landmarks.push_back(p_world_landmark);
  }
  for (std::size_t method = 0; method < info.methods.size(); ++method) {
    SqliteStatement row =
        impl_->file().prepare("SELECT positions FROM examples WHERE case_id = ? AND method = ?");
    row.put(impl_->id_of(study_case, method)).put(method);
    const std::string_view bytes = row.step() ? row.get_bytes() : std::string_view();
    if (bytes.size() % kBytesPerPosition != 0 || bytes.size() > kBytesPerPosition * info.frame_times.size()) {
      impl_->fail(
          fmt::format("a position for each of at most {} frames of '{}'", info.frame_times.size(), info.name),
          fmt::format("{} bytes", bytes.size()));
    }
    out.estimate.push_back(positions_from(bytes));
  }
  return out;
}

}  // namespace limber
