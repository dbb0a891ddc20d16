// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "limber/diagnose/run_summary.hpp"

namespace limber::app {

/// The figures of a run in ten lines on stdout, and a line for each parameter that it estimated.
void print_run_summary(const RunSummary& summary, const RunRecord& record,
                       const std::filesystem::path& folder);

}  // namespace limber::app
