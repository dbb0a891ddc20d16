// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "frame_feed.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/run/run_recording.hpp"
#include "remarks.hpp"
#include "start_smoothing.hpp"

namespace limber::detail {

/// Frames behind the start, into a navigator and a record. What it is made of must outlive it.
class FrameByFrame {
 public:
  /// Shows those that the record has already.
  /// @param first   of the recording that the record begins with
  /// @param points  of the frames in the record
  FrameByFrame(const Recording& recording, const RunOptions& options, const RunSetup& setup,
               const RunCallbacks& callbacks, std::size_t first, const PointCount& points,
               Navigator& navigator, RunRecord& record);

  /// Number of the next frame of the recording.
  [[nodiscard]] std::size_t next() const { return first_ + record_.frames.size(); }
  /// By the caller; asks it.
  [[nodiscard]] bool is_stopped();
  /// @throws DivergenceError if the filter diverges
  void take(const ReadFrame& read, WindowSmoother& smoother);
  /// Of all frames.
  [[nodiscard]] const PointCount& points() const { return points_; }

 private:
  void process(const StereoFrame& frame);
  void require_sane(std::int64_t t_ns) const;
  [[noreturn]] void fail(std::size_t n, std::int64_t t_ns, const std::string& what) const;
  void show(std::size_t row, const StereoFrame* frame) const;

  const Recording& recording_;
  const RunOptions& options_;
  const RunSetup& setup_;
  const RunCallbacks& callbacks_;
  std::size_t first_;
  Navigator& navigator_;
  RunRecord& record_;
  PointCount points_;
  InputFeed feed_;
};

}  // namespace limber::detail
