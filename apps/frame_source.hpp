// SPDX-License-Identifier: MIT
#pragma once

#include "limber/run/run_recording.hpp"

namespace limber::app {

/// Frames of a recording: its matched points, or its images through the front end. The recording must outlive
/// the source.
/// @throws std::runtime_error for images if this program was built without the front end
[[nodiscard]] FrameSource frame_source(const Recording& recording);

}  // namespace limber::app
