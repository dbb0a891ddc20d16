// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "start_from_sensors.hpp"

namespace limber::detail {

/// A start and who asked for it.
struct KeptStart {
  RunSetup setup;
  SensorWindow window;
};

/// Behind SharedStarts.
struct KeptStarts {
  std::vector<KeptStart> starts;

  /// Nothing if nobody has asked for the same.
  [[nodiscard]] std::optional<SensorWindow> find(const RunSetup& setup) const;
  void keep(const RunSetup& setup, const SensorWindow& window);
};

}  // namespace limber::detail
