// SPDX-License-Identifier: MIT
#include "limber/run/shared_starts.hpp"

#include "shared_starts.hpp"

namespace limber {
namespace detail {

const SensorWindow* KeptStarts::find(const RunSetup& setup) const {
  for (const KeptStart& start : starts) {
    if (same_start(start.setup.navigator, start.setup.calibration, setup.navigator, setup.calibration)) {
      return &start.window;
    }
  }
  return nullptr;
}

void KeptStarts::keep(const RunSetup& setup, const SensorWindow& window) {
  starts.push_back({setup, window});
}

}  // namespace detail

SharedStarts::SharedStarts() : kept_(std::make_unique<detail::KeptStarts>()) {}
SharedStarts::~SharedStarts() = default;

std::size_t SharedStarts::size() const { return kept_->starts.size(); }

}  // namespace limber
