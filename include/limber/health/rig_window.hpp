// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "limber/health/window_fit.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// @file
/// What the right pixels of a stretch of frames say of the rig, with errors that are not white.
namespace limber {

/// The frames of one window.
class RigWindow {
 public:
  /// @param calibration  as it is believed to be
  explicit RigWindow(const StereoCalibration& calibration);

  /// @param follows  the pose can be trusted to have followed the motion since the frame before
  void add(const StereoFrame& frame, const Pose& T_world_cam0, bool follows);

  /// No frame since the window began.
  [[nodiscard]] bool empty() const { return collected_.frames.empty(); }
  /// Time of its first frame [ns]; only if there is one.
  [[nodiscard]] std::int64_t from_ns() const { return collected_.from_ns; }

  /// The regression of the frames so far, not begun yet.
  [[nodiscard]] WindowFit fit() const { return WindowFit(collected_); }
  /// The same, and begins the next window.
  [[nodiscard]] WindowFit close();

 private:
  detail::WatchedFrames collected_;
  int stretch_ = 0;  // of poses that follow each other
};

}  // namespace limber
