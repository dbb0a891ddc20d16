// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "limber/run/run_recording.hpp"

namespace limber::app {

struct ViewArguments {
  std::filesystem::path page;  ///< empty: none is written
  bool live = false;
  std::uint16_t port = 0;
  bool paused = false, exit_at_end = false;
};

/// --view and what belongs to it.
void add_view_options(CLI::App& command, ViewArguments& arguments);

/// @brief A run that pages in a browser look on at, or that is recorded as such a page. It changes nothing of
/// the run but its pace, and that only where a page asks for it.
class LiveView {
 public:
  virtual ~LiveView() = default;  ///< gives the pages a second to hear of the end

  /// Shows a frame that is done, and waits while the run is paused.
  virtual void show(const ObservedFrame& frame) = 0;
  /// Shows a frame that a start from the sensors has taken in.
  virtual void show(const WaitingFrame& frame) = 0;
  /// Time that pages have held up the run [s].
  [[nodiscard]] virtual double held_s() const = 0;
  /// The run is over; tells the pages, and writes the one that was asked for.
  virtual void finish(const std::string& message) = 0;
  /// Keeps the page served: on a terminal until Ctrl-C, else as long as it is looked at.
  virtual void stay() = 0;
};

/// @brief Serves the page and says where it is, and records one; null unless something is asked for.
/// @param recording  must outlive the view
/// @param frontend   what is known of the front end so far; null for matched points
/// @param stop       asked while the run is paused: true ends the pause
/// @throws std::runtime_error if the port cannot be listened on, or this program was built without the page
[[nodiscard]] std::unique_ptr<LiveView> open_live_view(const ViewArguments& arguments,
                                                       const Recording& recording, const RunOptions& options,
                                                       std::shared_ptr<const FrontendRecord> frontend,
                                                       std::function<bool()> stop);

}  // namespace limber::app
