// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "fleet.hpp"
#include "ordered_json.hpp"

/// How the rigs of a fleet drift from recording to recording.
namespace limber::app {

/// Whether a stamp counts from 1970 [ns]: it lies behind the year 2000.
[[nodiscard]] bool is_dated(std::int64_t t_ns);

/// The slope of one axis of θ, and half of its 95 % interval [rad or m, per unit of time].
struct AxisTrend {
  double slope = 0.0, half_width = 0.0;
  [[nodiscard]] bool is_certain() const { return slope > half_width || slope < -half_width; }
};

/// Recordings with the same cameras, three or more.
struct FleetTrend {
  std::vector<std::size_t> rows;                 ///< of the fleet, in their order
  std::string per;                               ///< "day", "hour" or "recording" where stamps are no dates
  std::array<std::optional<AxisTrend>, 6> axes;  ///< ax ... tz; nothing where a recording does not know it
};

/// @brief A line through the true θ of each recording (assumed plus error), weighted by its sigmas. Where the
/// recordings scatter more than those say, the interval is Student's of the scatter.
[[nodiscard]] std::vector<FleetTrend> fleet_trends(const std::vector<FleetRow>& rows);

[[nodiscard]] std::string to_text(const FleetTrend& trend, const std::vector<FleetRow>& rows);
[[nodiscard]] Json to_json(const FleetTrend& trend);

}  // namespace limber::app
