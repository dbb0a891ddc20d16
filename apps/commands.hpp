// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

/// One function per subcommand. Each adds its options and a callback that does the work.
///
/// The callback throws to fail: main() turns any std::exception into a message and exit code 1. A command
/// with further exit codes throws CLI::RuntimeError(code) after it has printed its result. What only the user
/// can get wrong (an option's value) is a CLI validator's business and ends with exit code 2; a file that is
/// missing or broken is not, so no CLI::ExistingFile.
namespace limber::app {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitUsage = 2;

void add_run_command(CLI::App& app);
void add_health_command(CLI::App& app);
void add_convert_command(CLI::App& app);
void add_info_command(CLI::App& app);
void add_simulate_command(CLI::App& app);
void add_decalibrate_command(CLI::App& app);  // LIMBER_WITH_FRONTEND
void add_compare_command(CLI::App& app);
void add_evaluate_command(CLI::App& app);
void add_smooth_command(CLI::App& app);       // LIMBER_WITH_SMOOTHER
void add_recalibrate_command(CLI::App& app);  // LIMBER_WITH_SMOOTHER
void add_study_command(CLI::App& app);
void add_paper_command(CLI::App& app);
void add_report_command(CLI::App& app);

}  // namespace limber::app
