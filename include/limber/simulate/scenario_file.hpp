// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "limber/simulate/scenario.hpp"

/// Scenarios as YAML. Every key is optional, unless it has no default (kind of a trajectory, path of its
/// file, shape and amplitude of a signal, end of a ramp); what is absent keeps the default of scenario.hpp,
/// with three exceptions that follow what the file says: cam1 is like cam0, filter.initial is like initial,
/// and filter.theta_sigma is 0.1 deg and 5 % of the baseline. Units are those of the comments that
/// format_scenario writes: SI, but angles in degrees. scenarios/README.md lists the keys.
namespace limber {

/// @throws DataError with file, line and key for an unknown or repeated key, a value of the wrong type, a
/// number out
///         of its range (which the message gives), broken YAML or an unreadable file
[[nodiscard]] Scenario read_scenario(const std::filesystem::path& path);

/// @brief The same for text in memory.
/// @param file stands in messages; its stem is the default name, its folder the root of relative paths
[[nodiscard]] Scenario parse_scenario(std::string_view text, const std::filesystem::path& file);

/// @brief The scenario fully resolved, every key with its value and unit. parse_scenario gives back the same
/// numbers, bit by bit, for whatever a file can say.
/// @throws std::invalid_argument if a value is out of its range; the message names the key
[[nodiscard]] std::string format_scenario(const Scenario& scenario);

/// @throws std::invalid_argument if a value is out of its range; the message names the key
void check_scenario(const Scenario& scenario);

}  // namespace limber
