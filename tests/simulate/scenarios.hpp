// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "limber/datasets/recording.hpp"
#include "shipped_scenario.hpp"

/// Scenarios of the tests of the simulator, and what is counted in its recordings.
namespace limber::testing {

/// A few seconds of the paper's case (i).
inline Scenario brief(double duration = 3.0) {
  Scenario s;
  s.duration = duration;
  return s;
}

inline std::size_t observation_count(const Recording& recording) {
  std::size_t n = 0;
  for (const StereoFrame& frame : recording.frames) {
    n += frame.observations.size();
  }
  return n;
}

}  // namespace limber::testing
