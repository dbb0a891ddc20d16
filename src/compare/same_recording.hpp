// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "run_files/run_folder.hpp"

namespace limber::detail {

/// Rows of two trajectories at the same time.
[[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> common_frames(const RunFolder& a,
                                                                             const RunFolder& b);

/// Same name, same frames where both were under way, and the same true motion where both know it.
[[nodiscard]] bool same_recording(const RunFolder& a, const RunFolder& b);

/// What two runs of a recording assume differently of it, in words; what their methods are told to do with it
/// (constraints, estimated parameters, map, gate) is no assumption.
[[nodiscard]] std::vector<std::string> different_assumptions(const RunFolder& a, const RunFolder& b);

}  // namespace limber::detail
