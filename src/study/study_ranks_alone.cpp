// SPDX-License-Identifier: MIT
// A build without MPI.
#include <stdexcept>

#include "launcher.hpp"
#include "limber/study/study_ranks.hpp"
#include "rank_workforce.hpp"

namespace limber {

StudyRanks::StudyRanks() {
  if (detail::launched_processes() > 1) {
    throw std::runtime_error(
        "several processes were started, but limber was built without MPI: use --shard with one --out for "
        "each, and limber study merge");
  }
}

StudyRanks::~StudyRanks() = default;

void StudyRanks::serve(int) {}

namespace detail {

std::unique_ptr<Workforce> make_rank_workforce(StudyRanks&, const StudyPlan& plan, int threads) {
  return make_local_workforce(plan, threads);
}

}  // namespace detail
}  // namespace limber
