// SPDX-License-Identifier: MIT
#include "limber/run/shared_starts.hpp"

#include <utility>

#include "shared_starts.hpp"

namespace limber {
namespace detail {

namespace {

SensorWindow of_counterpart(SensorWindow window) {
  std::swap(window.result, *window.counterpart);
  window.report = report_of(window.result, window.of_last_frame);
  return window;
}

}  // namespace

std::optional<SensorWindow> KeptStarts::find(const RunSetup& setup) const {
  for (const KeptStart& start : starts) {
    if (same_start(start.setup.navigator, start.setup.calibration, setup.navigator, setup.calibration)) {
      return may_trust_rig(start.setup.navigator) == may_trust_rig(setup.navigator)
                 ? start.window
                 : of_counterpart(start.window);
    }
  }
  return std::nullopt;
}

void KeptStarts::keep(const RunSetup& setup, const SensorWindow& window) {
  starts.push_back({setup, window});
}

}  // namespace detail

SharedStarts::SharedStarts() : kept_(std::make_unique<detail::KeptStarts>()) {}
SharedStarts::~SharedStarts() = default;

std::size_t SharedStarts::size() const { return kept_->starts.size(); }

}  // namespace limber
