// SPDX-License-Identifier: MIT
#include "limber/study/run_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "rank_workforce.hpp"
#include "study_store.hpp"
#include "workforce.hpp"

namespace limber {
namespace {

using detail::Finished;
using detail::StudyStore;
using detail::Task;
using detail::Workforce;

constexpr std::chrono::milliseconds kTick{100};

/// The items of a shard, run by run through all cases, so that early results cover everything.
class Items {
 public:
  Items(const StudyPlan& plan, const Shard& shard) : plan_(plan), shard_(shard) {
    for (const StudyCase& study_case : plan.cases) {
      most_runs_ = std::max(most_runs_, study_case.runs);
    }
  }

  /// Calls visit(task) until it returns false.
  template <typename Visit>
  void each(Visit visit) const {
    Items copy(plan_, shard_);
    while (const std::optional<Task> task = copy.next()) {
      if (!visit(*task)) {
        return;
      }
    }
  }

  [[nodiscard]] std::optional<Task> next() {
    for (; run_ < most_runs_; ++run_, case_ = 0) {
      while (case_ < plan_.cases.size()) {
        const Task task{case_++, run_};
        if (run_ < plan_.cases[task.study_case].runs &&
            (task.study_case + run_) % shard_.count == shard_.index - 1) {
          return task;
        }
      }
    }
    return std::nullopt;
  }

 private:
  const StudyPlan& plan_;
  Shard shard_;
  std::uint64_t most_runs_ = 0, run_ = 0;
  std::size_t case_ = 0;
};

int threads_of(const StudyOptions& options, const StudyRanks* ranks) {
  if (options.threads > 0) {
    return options.threads;
  }
  const bool shared = ranks != nullptr && ranks->size() > 1;
  return shared ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// One call of run_study.
class Study {
 public:
  Study(const StudyPlan& plan, const std::filesystem::path& database, const StudyOptions& options,
        StudyRanks* ranks)
      : plan_(plan),
        options_(options),
        ranks_(ranks),
        threads_(threads_of(options, ranks)),
        store_(database, plan, start_record()),
        items_(plan, options.shard) {
    count();
  }

  StudyOutcome run() {
    if (outcome_.progress.runs == outcome_.progress.total) {
      outcome_.progress.share = 1.0;
      return outcome_;
    }
    const auto workforce = ranks_ != nullptr && ranks_->size() > 1
                               ? detail::make_rank_workforce(*ranks_, plan_, threads_)
                               : detail::make_local_workforce(plan_, threads_);
    while (!outcome_.stopped) {
      fill(*workforce);
      if (under_way_ == 0) {
        break;
      }
      if (auto finished = workforce->take(kTick)) {
        book(std::move(*finished));
      }
      report(*workforce);
      outcome_.stopped = options_.stop && options_.stop();
    }
    return outcome_;
  }

 private:
  [[nodiscard]] detail::StartRecord start_record() const {
    return {std::string(program_version()), ranks_ != nullptr ? ranks_->size() : 1, threads_,
            fmt::format("{}/{}", options_.shard.index, options_.shard.count)};
  }

  [[nodiscard]] std::uint64_t methods_of(const Task& task) const {
    return plan_.cases[task.study_case].methods.size();
  }

  /// Counts what there is and what is to do, and picks a finished item to be computed anew.
  void count() {
    items_.each([&](const Task& task) {
      const std::uint64_t methods = methods_of(task);
      outcome_.progress.total += methods;
      if (store_.is_finished(task.study_case, task.run)) {
        outcome_.progress.runs += methods;
        again_ = again_.value_or(task);
      } else {
        frames_to_do_ += methods * frame_times_[task.study_case];
      }
      return true;
    });
    if (again_) {
      frames_to_do_ += methods_of(*again_) * frame_times_[again_->study_case];
    }
  }

  [[nodiscard]] std::optional<Task> next() {
    if (again_) {
      return std::exchange(again_, std::nullopt);
    }
    std::optional<Task> task = items_.next();
    while (task && store_.is_finished(task->study_case, task->run)) {
      task = items_.next();
    }
    return task;
  }

  void fill(Workforce& workforce) {
    while (under_way_ < workforce.capacity()) {
      const std::optional<Task> task = next();
      if (!task) {
        return;
      }
      workforce.submit(*task);
      ++under_way_;
    }
  }

  void book(Finished finished) {
    --under_way_;
    if (finished.error) {
      std::rethrow_exception(finished.error);
    }
    const ItemResult& result = *finished.result;
    if (store_.is_finished(result.study_case, result.run)) {
      store_.compare(result);
      return;
    }
    store_.save(result);
    outcome_.progress.runs += result.methods.size();
    outcome_.progress.now += result.methods.size();
  }

  void report(const Workforce& workforce) {
    // Runs that diverge have fewer frames than was thought: never more than what the finished runs say.
    outcome_.progress.share =
        std::min(1.0, static_cast<double>(workforce.frames_done()) / static_cast<double>(frames_to_do_));
    if (options_.progress) {
      options_.progress(outcome_.progress);
    }
  }

  [[nodiscard]] static std::vector<std::uint64_t> frames_of(const StudyPlan& plan) {
    std::vector<std::uint64_t> frames;
    for (const StudyCase& study_case : plan.cases) {
      frames.push_back(frame_times(study_case.scenario).size());
    }
    return frames;
  }

  const StudyPlan& plan_;
  const StudyOptions& options_;
  StudyRanks* ranks_;
  int threads_;
  StudyStore store_;
  Items items_;
  std::vector<std::uint64_t> frame_times_ = frames_of(plan_);
  StudyOutcome outcome_;
  std::optional<Task> again_;
  std::uint64_t frames_to_do_ = 0;
  std::size_t under_way_ = 0;
};

}  // namespace

Shard shard_from_string(std::string_view text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, index_error] = std::from_chars(text.data(), end, shard.index);
  if (index_error == std::errc() && slash != end && *slash == '/') {
    const auto [rest, count_error] = std::from_chars(slash + 1, end, shard.count);
    if (count_error == std::errc() && rest == end && shard.index >= 1 && shard.index <= shard.count) {
      return shard;
    }
  }
  throw std::invalid_argument(
      fmt::format("expected a shard INDEX/COUNT such as 1/4 to 4/4, found '{}'", text));
}

StudyOutcome run_study(const StudyPlan& plan, const std::filesystem::path& database,
                       const StudyOptions& options, StudyRanks* ranks) {
  check_plan(plan);
  return Study(plan, database, options, ranks).run();
}

std::string_view program_version() { return LIMBER_VERSION; }

}  // namespace limber
