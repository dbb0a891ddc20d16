// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <vector>

#include "frame_feed.hpp"
#include "limber/initialize/sensor_start.hpp"

namespace limber::detail {

/// Lets the frames of a start have what those behind it say of them, while the filter goes on. Runs that
/// share the start share this, one after the other.
class StartSmoothing {
 public:
  /// @param start     over, and handed over
  /// @param feed      of the inputs behind the start
  /// @param begin_ns  the start's first frame
  StartSmoothing(SensorStart start, InputFeed feed, MotionModel motion, std::int64_t begin_ns);

  /// A frame behind the start's. Those that are too late to tell anything are left out, as are those that
  /// another run has shown.
  void add(const StereoFrame& frame);
  /// No frame that comes now tells more.
  [[nodiscard]] bool complete() const { return complete_; }
  /// Of the start's first frames, as this method has them. No frame may be added any more.
  /// @param how  async: on a thread of its own; deferred: once the states are asked for
  void begin(Method method, std::size_t frames, std::launch how);
  /// What was begun; none if what came since the start contradicts it, or leaves no solution.
  [[nodiscard]] std::vector<SmoothedState> states() { return states_.get(); }

 private:
  SensorStart start_;
  InputFeed feed_;
  MotionModel motion_;
  std::int64_t begin_ns_, last_ns_;
  bool complete_ = false;
  std::future<std::vector<SmoothedState>> states_;
};

/// What one run makes of it.
class WindowSmoother {
 public:
  /// @param smoothing  none: no state is smoothed
  /// @param frames     of the start
  /// @param threads    1: after the last frame, more: beside the filter
  WindowSmoother(StartSmoothing* smoothing, Method method, std::size_t frames, int threads);

  /// A frame that the filter has got.
  void add(const StereoFrame& frame);
  /// After the last frame: of the start's frames; none if they stay as they are, or were asked for before.
  [[nodiscard]] std::vector<SmoothedState> states();

 private:
  void begin();

  StartSmoothing* smoothing_;
  Method method_;
  std::size_t frames_;
  std::launch how_;
  bool has_begun_ = false;
};

}  // namespace limber::detail
