// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "limber/run/run_recording.hpp"

/// What a user should know about a recording and a run beside the results: in plain words, with numbers.
namespace limber::detail {

[[nodiscard]] std::int64_t frame_time(const SensorData& sensors, std::size_t n);  ///< [ns]

/// "0.000 s to 34.990 s"
[[nodiscard]] std::string covered_seconds(std::int64_t begin_ns, std::int64_t end_ns);
[[nodiscard]] std::string covered_by_frames(const Recording& recording);

/// What the recording lacks for this motion model: input samples missing, units that look wrong, ground truth
/// of another time.
[[nodiscard]] std::vector<std::string> remarks_on_input(const Recording& recording, MotionModel motion,
                                                        double gravity);

/// How many of the points of all frames each camera saw.
struct PointCount {
  std::size_t left = 0, right = 0;
  struct Time {
    std::int64_t t_ns;
  };
  std::vector<Time> seen_by_right;  ///< of frames in which the right one saw any

  void add(const StereoFrame& frame);
};

/// What the measurements did in this run: cameras that saw nothing, residuals that contradict the model.
/// @param sigma_px  assumed
[[nodiscard]] std::vector<std::string> remarks_on_measurements(const RunRecord& record, Method method,
                                                               const PixelNoise& sigma_px,
                                                               const PointCount& points);

}  // namespace limber::detail
