// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// The index of the first frame at least this long [s] after frames[n], nothing where there is none within
/// twice of it.
[[nodiscard]] std::optional<std::size_t> frame_after(std::span<const StereoFrame> frames, std::size_t n,
                                                     double seconds);

/// How the body turned over a while, by the left camera.
struct Turn {
  double begin_s = 0.0, end_s = 0.0;  ///< since the origin
  Eigen::Vector3d rate;               ///< mean over it, body frame [rad/s]
  double confusion = 1.0;             ///< as of TwoViews
};

/// Of a fifth of a second each, one from each frame on: over less the noise of pixels is large beside the
/// motion, and bends what they say of turns.
[[nodiscard]] std::vector<Turn> left_turns(const StereoCalibration& calibration,
                                           std::span<const StereoFrame> frames, std::int64_t origin_ns);

}  // namespace limber::detail
