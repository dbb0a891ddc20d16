// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "limber/study/study_ranks.hpp"
#include "workforce.hpp"

namespace limber::detail {

/// Rank 0: its own threads and all those of the other ranks, which must be in StudyRanks::serve. `plan` must
/// outlive it. Only once per StudyRanks.
[[nodiscard]] std::unique_ptr<Workforce> make_rank_workforce(StudyRanks& ranks, const StudyPlan& plan,
                                                             int threads);

}  // namespace limber::detail
