// SPDX-License-Identifier: MIT
// Takes the place of live_view.cpp in a build without cpp-httplib or the page.
#include <stdexcept>

#include "live_view.hpp"

namespace limber::app {

void add_view_options(CLI::App& command, ViewArguments& arguments) {
  command.add_flag("--view", arguments.live,
                   "Not in this build: it needs libcpp-httplib-dev, nodejs and npm");
}

std::unique_ptr<LiveView> open_live_view(const ViewArguments& arguments, const Recording&, const RunOptions&,
                                         std::shared_ptr<const FrontendRecord>, std::function<bool()>) {
  if (!arguments.live) return nullptr;
  throw std::runtime_error(
      "this program was built without the live view: install libcpp-httplib-dev, nodejs and npm and build it "
      "again");
}

}  // namespace limber::app
