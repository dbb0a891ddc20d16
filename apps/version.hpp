// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace limber::app {

/// What `limber --version` prints: version; commit, processor and parts of this build.
[[nodiscard]] std::string version_text();

}  // namespace limber::app
