// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis.hpp"

/// `limber health --fleet`: many recordings, a row each.
namespace limber::app {

struct FleetRow {
  std::string dataset;                 ///< as it was given
  std::optional<Diagnosis> diagnosis;  ///< with `since` against the first recording of the same cameras
  std::string failure;                 ///< why there is no diagnosis; empty also where `stopped`
  bool stopped = false;                ///< the user did not want to wait for it
};

/// Compares each row with the first one before it that has the same cameras.
void compare_with_first(std::vector<FleetRow>& rows);

/// 1 if a recording could not be judged at all, or not to its end, else that of the worst verdict.
[[nodiscard]] int fleet_exit_code(const std::vector<FleetRow>& rows);

[[nodiscard]] std::string fleet_text(const std::vector<FleetRow>& rows);
/// An array with what `limber health --json` says of each, or `dataset` and `failure`, and its `trend`: that
/// of its cameras, or null.
[[nodiscard]] std::string fleet_json(const std::vector<FleetRow>& rows);

}  // namespace limber::app
