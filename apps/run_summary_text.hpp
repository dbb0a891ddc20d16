// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "limber/diagnose/run_summary.hpp"

namespace limber::app {

/// The figures of a run in ten lines on stdout.
void print_run_summary(const RunSummary& summary, const std::filesystem::path& folder);

}  // namespace limber::app
