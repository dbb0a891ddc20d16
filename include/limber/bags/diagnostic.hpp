// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace limber {

/// How a part of a robot is, as diagnostic_msgs/DiagnosticStatus has it.
struct Diagnostic {
  /// With ROS's numbers.
  enum class Level : std::uint8_t { kOk = 0, kWarning = 1, kError = 2, kStale = 3 /*!< not known */ };
  /// [ns]
  std::int64_t t_ns = 0;
  /// kStale: nobody knows
  Level level = Level::kStale;
  /// name: of the part; message: its state in words
  std::string name, message;
  /// names and values, in the order in which they are shown
  std::vector<std::pair<std::string, std::string>> values;
};

}  // namespace limber
