// SPDX-License-Identifier: MIT
#include "source_folder.hpp"

namespace limber::testing {

std::filesystem::path source_folder() { return LIMBER_SOURCE_DIR; }

}  // namespace limber::testing
