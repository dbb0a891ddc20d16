// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "limber/compare/compare_runs.hpp"

/// A comparison of runs as text and as JSON. What is not known is a dash, or null.
namespace limber::app {

/// Tables: a row a run, then what the differences are.
[[nodiscard]] std::string to_text(const RunComparison& comparison);

/// {runs, differences, notes}: docs/compare.md.
[[nodiscard]] std::string to_json(const RunComparison& comparison);

}  // namespace limber::app
