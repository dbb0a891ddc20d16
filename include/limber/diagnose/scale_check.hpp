// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>

#include "limber/health/calibration_watch.hpp"
#include "limber/run/run_recording.hpp"

/// @file
/// Whether the scale of a trajectory that rests on the baseline's length is the one that the IMU shows alone,
/// and whether the trajectory is.
namespace limber {

/// The scale of a run over a stretch, beside that of `lcekf`, which asks the IMU alone.
struct ScaleCheck {
  /// first and last frame of the stretch
  std::int64_t from_ns = 0, to_ns = 0;
  TrajectoryScale scale;  ///< of the run's trajectory; sigma: at least 1 %
};

/// Whether a trajectory's scale is another one than the inputs show: by chance once in a thousand runs.
[[nodiscard]] bool is_off(const TrajectoryScale& scale);

/// @brief Runs `lcekf` once more over the last 30 s of a run (RunRecord::last_frames).
///
/// The velocities, as the body sees them in either run, give the scale; their sigmas over the speed say how
/// well `lcekf` knows its own. Of each frame 60 points are taken.
/// @return nothing where no frames were kept, `lcekf` did not go through, or does not know its scale either
[[nodiscard]] std::optional<ScaleCheck> check_scale(const Recording& recording, const RunOptions& options,
                                                    const RunRecord& record);

/// @brief The same run: whether the velocities since `since_ns` agree with those of `lcekf` within what both
/// claim, in the median frame. A filter that points led astray does not.
/// @return nothing where there is nothing to compare
[[nodiscard]] std::optional<bool> agrees_with_lcekf(const Recording& recording, const RunOptions& options,
                                                    const RunRecord& record, std::int64_t since_ns);

}  // namespace limber
