// SPDX-License-Identifier: MIT
// Takes the place of the generated page in a build without npm.
#include "page_template.hpp"

namespace limber::detail {

std::string_view page_template() { return {}; }

}  // namespace limber::detail
