// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "limber/view/view_board.hpp"

namespace limber::testing {

inline ViewRun small_run() {
  ViewRun run{.title = "small", .method = "lcekf", .frames = 100, .calibration = {}, .watch = {}};
  run.calibration.theta(3) = -0.1;
  return run;
}

inline ViewFrame small_frame(std::size_t number) {
  ViewFrame frame;
  frame.number = number;
  frame.t_s = 0.05 * static_cast<double>(number);
  frame.T_world_body.p.x() = static_cast<double>(number);
  frame.points.push_back({{7, {1.0, 2.0}, {3.0, 4.0}, true, false}, ViewPointFate::kRefused});
  frame.map.push_back({7, {1.0, 2.0, 3.0}});
  frame.stages.push_back({"filter", 1.5});
  return frame;
}

/// Name of a server-sent event; empty for a comment.
inline std::string name_of_event(const std::string& event) {
  const std::size_t at = event.find("event: ");
  return at == std::string::npos ? "" : event.substr(at + 7, event.find('\n', at) - at - 7);
}

/// Its data.
inline nlohmann::json data_of(const std::string& event) {
  const std::size_t at = event.find("data: ");
  return nlohmann::json::parse(event.substr(at + 6, event.find('\n', at) - at - 6));
}

}  // namespace limber::testing
