// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "limber/diagnose/run_summary.hpp"

namespace limber::app {

/// The answer of a run and its figures on stdout, and a line for each parameter that it estimated.
void print_run_summary(const RunOptions& options, const RunRecord& record, const RunSummary& summary,
                       const std::filesystem::path& folder);

}  // namespace limber::app
