// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace limber::testing {

/// The project's own folder, where scenarios/ is.
std::filesystem::path source_folder();

}  // namespace limber::testing
