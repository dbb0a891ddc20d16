// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "limber/run/run_recording.hpp"

namespace limber::app {

struct FrontendArguments {
  int max_tracks = 120;  ///< points followed at a time
  /// 1: images are decoded and tracked when the filter asks for them; 2: ahead of it; 3: each ahead
  int threads = 3;
};

/// Pairs of images that could not be read. Each is a frame without points.
struct DamagedPairs {
  std::size_t frames = 0;        ///< that were taken
  std::vector<std::string> why;  ///< when, where and why, of each damaged one
};

/// Frames of a recording: its matched points, or its images through the front end.
struct ImageFrames {
  FrameSource frames;
  std::shared_ptr<FrontendRecord> record{};  ///< of the frames taken so far; nothing for matched points
  std::shared_ptr<DamagedPairs> damaged{};   ///< the same
};

/// Adds to notes what could not be read; nothing where all could. @return whether there was any
bool note_damaged(const ImageFrames& source, std::vector<std::string>& notes);

/// The same of a run, which is partial then and has their number.
void add_damaged(const ImageFrames& source, RunRecord& record);

/// @brief A pair that cannot be read is a frame without points, unless the first ten are all so: then the
/// first reason is thrown (DataError).
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

}  // namespace limber::app
