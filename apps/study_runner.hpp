// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "limber/study/run_study.hpp"

/// What `study` and `paper` share: how a study is run before the user's eyes.
namespace limber::app {

struct RunnerArguments {
  int threads = 0;
  std::string shard = "1/1";
  std::string export_format;  ///< csv, json or nothing
  bool force = false;
};

void add_runner_options(CLI::App& command, RunnerArguments& arguments);

/// @brief Runs what is missing of a study, with a progress bar.
/// @return whether all of it (of this shard) is there; else the user has asked to stop, and is told how to go
/// on
bool run_with_progress(const StudyPlan& plan, const std::filesystem::path& database,
                       const RunnerArguments& arguments, StudyRanks& ranks);

/// Writes what --export asks for, and says where.
void export_study(const std::filesystem::path& database, const std::string& format);

}  // namespace limber::app
