// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "limber/clean/frame_cleaner.hpp"

namespace limber::testing {

using Frames = std::vector<StereoFrame>;
using Tracks = std::vector<std::int64_t>;

inline constexpr std::int64_t kStepNs = 50'000'000;

inline StereoCalibration rig_of(double baseline) {
  StereoCalibration rig;
  rig.cam0 = rig.cam1 = {500.0, 500.0, 320.0, 240.0, 640, 480, NoDistortion{}};
  rig.theta(3) = -baseline;
  return rig;
}

inline Tracks tracks_of(const StereoFrame& frame) {
  Tracks out;
  for (const StereoObservation& point : frame.observations) {
    out.push_back(point.track_id);
  }
  return out;
}

inline Tracks matched_in(const StereoFrame& frame) {
  Tracks out;
  for (const StereoObservation& point : frame.observations) {
    if (point.in_cam1) {
      out.push_back(point.track_id);
    }
  }
  return out;
}

struct Cleaned {
  Frames frames;
  CleaningReport report;
};

inline Cleaned cleaned(const Frames& frames, const StereoCalibration& rig,
                       const CleaningOptions& options = {}) {
  FrameCleaner cleaner(rig, options);
  Cleaned out;
  for (const StereoFrame& frame : frames) {
    out.frames.push_back(cleaner.clean(frame));
  }
  out.report = cleaner.report();
  return out;
}

}  // namespace limber::testing
