// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "limber/sensors/samples.hpp"

namespace limber::testing {

/// Whether two hold the same bits.
inline bool same(const StereoObservation& a, const StereoObservation& b) {
  return a.track_id == b.track_id && a.in_cam0 == b.in_cam0 && a.in_cam1 == b.in_cam1 &&
         a.uv_cam0 == b.uv_cam0 && a.uv_cam1 == b.uv_cam1;
}

inline bool same(const StereoFrame& a, const StereoFrame& b) {
  return a.t_ns == b.t_ns &&
         std::equal(a.observations.begin(), a.observations.end(), b.observations.begin(),
                    b.observations.end(),
                    [](const StereoObservation& x, const StereoObservation& y) { return same(x, y); });
}

}  // namespace limber::testing
