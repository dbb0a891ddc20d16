// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// Ends tracks that were not tracked into a frame; see FrameCleaner.
class StaleTracks {
 public:
  /// @return number of points that were taken out of the frame
  std::size_t end(StereoFrame& frame);

 private:
  [[nodiscard]] bool is_stale(const StereoFrame& frame) const;
  [[nodiscard]] std::int64_t called(std::int64_t id) const;

  std::unordered_map<std::int64_t, StereoObservation> before_;  // the last frame as it came
  std::unordered_map<std::int64_t, std::int64_t> renamed_;      // as it came -> as it is called by now
  std::int64_t next_id_ = -1'000'000'000;                       // and down: where no front end counts
  std::size_t frames_ = 0, stale_ = 0;
};

}  // namespace limber::detail
