// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "limber/compare/compare_runs.hpp"
#include "limber/evaluate/association.hpp"
#include "run_files/run_folder.hpp"

namespace limber::detail {

/// The folders, read.
[[nodiscard]] std::vector<RunFolder> read_run_folders(std::span<const std::filesystem::path> folders);

/// compare_runs of folders that were read.
[[nodiscard]] RunComparison compare_folders(const std::vector<RunFolder>& runs,
                                            const CompareOptions& options);

/// What one run says by itself; label and piece_m are the caller's.
[[nodiscard]] ComparedRun compared_run(const RunFolder& run, double piece_m);

/// Where a run's relative errors come from: the truth, or the estimate itself where there is none.
[[nodiscard]] std::vector<MatchedPose> poses_on_path(const RunFolder& run);

/// See CompareOptions::piece_m. @param poses  not empty
[[nodiscard]] double default_piece(std::span<const MatchedPose> poses);

}  // namespace limber::detail
