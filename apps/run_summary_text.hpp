// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "limber/run/run_output.hpp"

namespace limber::app {

/// The figures of a run in ten lines on stdout.
void print_run_summary(const RunSummary& summary, const std::filesystem::path& folder);

}  // namespace limber::app
