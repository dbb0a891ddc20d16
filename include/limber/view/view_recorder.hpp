// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "limber/view/view_frame.hpp"

namespace limber {

namespace detail {
class ThinnedPath;
}  // namespace detail

/// @brief Keeps at most kMostFrames frames of a run, evenly, and the path; writes them as a page that shows
/// them without a server.
class ViewRecorder {
 public:
  /// in a page
  static constexpr std::size_t kMostFrames = 240;

  /// @param run  what does not change
  explicit ViewRecorder(ViewRun run);
  ~ViewRecorder();
  ViewRecorder(const ViewRecorder&) = delete;
  ViewRecorder& operator=(const ViewRecorder&) = delete;

  /// Every frame: where it was.
  void note(double t_s, const Eigen::Vector3d& p_world_body);
  /// Whether the frame of this number is one of those that are kept.
  [[nodiscard]] bool wants(std::size_t number) const;
  /// Keeps a frame; calls frame.images now.
  void add(const ViewFrame& frame);
  /// @brief Writes the page, complete or not at all.
  /// @param message  how the run ended
  /// @throws DataError if the file cannot be written
  void write(const std::filesystem::path& file, const std::string& message) const;

 private:
  const ViewRun run_;
  const std::size_t stride_;
  std::unique_ptr<detail::ThinnedPath> path_;
  std::vector<std::string> frames_;  // JSON
};

}  // namespace limber
