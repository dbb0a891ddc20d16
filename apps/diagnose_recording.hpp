// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>

#include "diagnosis.hpp"
#include "frame_source.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"

namespace limber::app {

/// @brief Is the calibration of a recording the problem? Navigates through it, and looks for mistakes and
/// clocks that disagree in the frames that were seen. A run that a mistake made impossible is a diagnosis.
/// @param options   method lcekf, which no calibration can lead astray
/// @param progress  told the number of frames done; may be empty
/// @param done      told of the run once it is over; may be empty
/// @param stop      asked before every frame: true ends the run, and what was seen by then is judged, without
///                  ekf beside it and without a state to keep; may be empty
/// @throws as run_recording, unless a mistake explains it; std::runtime_error if it was stopped before the
/// first frame
[[nodiscard]] Diagnosis diagnose_recording(
    const Recording& recording, const RunOptions& options, const ImageFrames& frames,
    const std::function<void(std::size_t)>& progress = {},
    const std::function<void(const RunRecord&, const RunSummary&)>& done = {},
    const std::function<bool()>& stop = {});

}  // namespace limber::app
