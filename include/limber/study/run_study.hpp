// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

#include "limber/study/study_plan.hpp"
#include "limber/study/study_ranks.hpp"

namespace limber {

/// One of `count` parts of a study, for machines that know nothing of each other (job arrays). 1 <= index <=
/// count.
struct Shard {
  /// from 1 on
  std::uint64_t index = 1;
  /// how many shards there are
  std::uint64_t count = 1;
};

/// "2/4". @throws std::invalid_argument for anything else
[[nodiscard]] Shard shard_from_string(std::string_view text);

/// How far a study is.
struct StudyProgress {
  std::uint64_t runs = 0;   ///< runs of a method that are in the database, of this shard
  std::uint64_t total = 0;  ///< that will be there in the end
  std::uint64_t now = 0;    ///< of `runs`: by this call
  double share = 0.0;       ///< of the work of this call that is done, 0 to 1
};

/// How a study is computed; nothing that its results depend on.
struct StudyOptions {
  int threads = 0;  ///< that compute, in this process; 0: one per core, or one if there are other ranks
  /// which part of the study this process computes
  Shard shard;
  std::function<bool()> stop;  ///< asked several times a second: true ends the study early
  std::function<void(const StudyProgress&)> progress;  ///< told several times a second
};

/// How far a call came.
struct StudyOutcome {
  /// when it ended
  StudyProgress progress;
  bool stopped = false;  ///< by StudyOptions::stop
};

/// @brief Computes what is missing of a study, and keeps it in a database.
/// One transaction per run of a case (all its methods): killed at any moment, the database holds what was
/// finished, and the same call goes on from there. Its content does not depend on threads, ranks, shards or
/// interruptions, but for the table `starts` and columns that start with ms_. Before it goes on with what
/// another call began, one finished run is computed anew and compared.
/// @param ranks other processes that help; may be null. This must be rank 0.
/// @throws DataError if the database cannot be used or written; std::runtime_error if it belongs to another
/// study; std::invalid_argument if check_plan does; what `simulate` throws
StudyOutcome run_study(const StudyPlan& plan, const std::filesystem::path& database,
                       const StudyOptions& options = {}, StudyRanks* ranks = nullptr);

/// The version that databases are marked with.
[[nodiscard]] std::string_view program_version();

}  // namespace limber
