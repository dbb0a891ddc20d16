// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

#include "limber/view/view_frame.hpp"

namespace limber::detail {

/// The run as JSON, for src/view/page.
[[nodiscard]] std::string to_json(const ViewRun& run);
/// A frame as JSON in one line; calls frame.images.
[[nodiscard]] std::string to_json(const ViewFrame& frame, const WatchOptions& watch);

/// A text as a JSON string; what is no UTF-8 is replaced.
[[nodiscard]] std::string json_string(const std::string& text);

/// A server-sent event; `data` is one line.
[[nodiscard]] std::string server_sent_event(std::string_view name, std::string_view data);

/// A frame that is turned into text once, by the first who needs it.
struct EncodedFrame {
  std::uint64_t sequence = 0;
  ViewFrame frame;

  /// An event `frame`; any thread.
  [[nodiscard]] const std::string& event(const WatchOptions& watch);

 private:
  std::once_flag once_;
  std::string event_;
};

}  // namespace limber::detail
