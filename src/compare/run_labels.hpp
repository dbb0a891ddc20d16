// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "run_files/run_folder.hpp"

namespace limber::detail {

/// A short name for each run: its method where no two are alike, else its folder without what all folders
/// begin with.
/// @throws std::invalid_argument if a folder comes twice
[[nodiscard]] std::vector<std::string> run_labels(const std::vector<RunFolder>& runs);

}  // namespace limber::detail
