// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "limber/diagnose/run_summary.hpp"

namespace limber {

/// @brief All that a run says of itself: summarize, and then, in this order, whether an input has misled it
/// (add_misled), whether its scale is the one that inputs show (add_scale_check), whether rows take the time
/// that was assumed (add_readout), whether its sigmas take a rig for exact that is not (add_trusted_rig), and
/// whether most points contradict it for seconds (add_overruled).
/// @param readout  of its frames, by a ReadoutWatch
/// @param record   gets notes on what is found
[[nodiscard]] RunSummary judge_run(const Recording& recording, const RunOptions& options,
                                   const std::optional<ReadoutTime>& readout, RunRecord& record);

}  // namespace limber
