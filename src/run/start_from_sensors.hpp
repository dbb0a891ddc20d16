// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "frame_feed.hpp"
#include "limber/initialize/sensor_start.hpp"
#include "remarks.hpp"
#include "start_smoothing.hpp"

namespace limber::detail {

/// The frames that a start from the sensors has used up, and what it made of them.
struct SensorWindow {
  SensorStartResult result;  // its trajectory is that of `frames`
  /// Of the methods that this start serves and that begin otherwise: of those that may trust the rig after
  /// all, or if it is one of theirs, of those that never do. Only of a start that is shared.
  std::optional<SensorStartResult> counterpart;
  StartReport report;         // of the result
  StartReport of_last_frame;  // why no more were waited for; kWaiting: there were none
  std::vector<FrameReport> frames;
  std::vector<double> source_ms, frame_ms;
  detail::PointCount points;
  std::deque<ReadFrame> ahead;  // read, and still to be processed
  std::shared_ptr<StartSmoothing>
      smoothing;             // of the result's trajectory; none where nothing is to be gained
  bool stopped = false;      // by the caller
  double elsewhere_s = 0.0;  // what it took, if another run has spent that [s]
};

/// What a run says of its start: why it waited no longer, and what is known with this result.
[[nodiscard]] StartReport report_of(const SensorStartResult& result, const StartReport& of_last_frame);

/// Reads frames from `first` on until they tell where the body is and how it moves, or the caller stops it:
/// then the window holds what is known by then, no frame if there was none.
/// @param shared  whether other methods may want this start
[[nodiscard]] SensorWindow start_from_sensors(const SensorData& sensors, const RunSetup& setup,
                                              const FrameSource& source, std::size_t first,
                                              const RunCallbacks& callbacks, bool shared);

}  // namespace limber::detail
