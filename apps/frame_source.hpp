// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>

#include "limber/run/run_recording.hpp"

namespace limber::app {

struct FrontendArguments {
  int max_tracks = 120;  ///< points followed at a time
  int threads = 2;       ///< 1: images are read and tracked when the filter asks for them
};

/// Frames of a recording: its matched points, or its images through the front end.
struct ImageFrames {
  FrameSource frames;
  std::shared_ptr<FrontendRecord> record;  ///< of the frames taken so far; nothing for matched points
};

/// @param recording  must outlive the source
/// @throws std::runtime_error for images if this program was built without the front end
[[nodiscard]] ImageFrames image_frames(const Recording& recording, const FrontendArguments& arguments);

/// The frames of a recording, from the first that a run wants on, once more with every call.
using RepeatedFrames = std::function<ImageFrames()>;

/// @brief For runs one after the other that begin with the same frame, over images that are read and tracked
/// once: frames are kept, some 6 kB each with 120 points, and a run that wants more goes on where those
/// before have ended.
/// @throws as image_frames, when called
[[nodiscard]] RepeatedFrames repeated_frames(const Recording& recording, const FrontendArguments& arguments);

/// The same frames, until the user asks to stop. @throws Stopped then, in the place of a frame
[[nodiscard]] FrameSource stoppable(FrameSource frames);

/// The frames alone, made on the thread that asks for them.
[[nodiscard]] FrameSource frame_source(const Recording& recording);

}  // namespace limber::app
