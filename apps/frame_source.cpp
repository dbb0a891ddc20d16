// SPDX-License-Identifier: MIT
#include "frame_source.hpp"

#include <memory>
#include <stdexcept>
#ifdef LIMBER_WITH_FRONTEND
#include "limber/frontend/stereo_tracker.hpp"
#endif

namespace limber::app {

FrameSource frame_source(const Recording& recording) {
  if (recording.images.empty()) {
    return matched_frames(recording);
  }
#ifdef LIMBER_WITH_FRONTEND
  auto tracker = std::make_shared<StereoTracker>(recording.calibration);
  return [tracker, &recording](std::size_t n) {
    const ImagePair& pair = recording.images[n];
    return tracker->process(pair.t_ns, pair.cam0, pair.cam1);
  };
#else
  throw std::runtime_error(recording.name +
                           " holds images, but this program was built without the image front end");
#endif
}

}  // namespace limber::app
