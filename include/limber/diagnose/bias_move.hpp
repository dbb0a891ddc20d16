// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "limber/datasets/trajectory_files.hpp"
#include "limber/navigate/frame_report.hpp"

namespace limber {

/// A bias of the IMU that moved further than the filter's own sigmas allow: one of them is not true.
struct BiasMove {
  bool of_gyro = false;  ///< else of the accelerometer
  /// frames between which it is seen: eight seconds at most [ns]
  std::int64_t from_ns = 0, to_ns = 0;
  double size = 0.0;                 ///< of the axis that moved [rad/s] or [m/s^2]
  double sigmas = 0.0;               ///< that size, in standard deviations
  double usual_sigmas = 0.0;         ///< a quarter of the moves of a second in the run are smaller [-]
  bool after_contradiction = false;  ///< images contradicted the inputs before, which opens the biases

  /// Twelve times what is usual, and nothing was said before: something failed. Else the sigmas may be too
  /// small all along, because pixels or clocks err in a way that nobody stated.
  [[nodiscard]] bool is_sudden() const;
};

/// @brief The first sudden move of a bias, else the first move, by more than twelve sigmas within one, two,
/// four or eight seconds.
///
/// What an estimate moves by has at most the variance that it had before, and what was added since. Nothing
/// else enters: no noise of pixels that is learned from a misfit, and no rig. A contradiction of images and
/// inputs, which opens the state, excuses what is two seconds before and behind it.
/// @param rows    of a run, with biases and their sigmas; the first ones may have none
/// @param frames  one per row
/// @throws std::invalid_argument if there are not as many frames as rows
/// @note docs/derivations/faults.md
[[nodiscard]] std::optional<BiasMove> bias_beyond_its_sigma(std::span<const TrajectoryRow> rows,
                                                            std::span<const FrameReport> frames);

/// @brief Since when a bias is estimated, for a second and with confidence (three sigmas), to be larger than
/// that of any sensor which is calibrated at all: 2 m/s^2, 0.2 rad/s [ns].
[[nodiscard]] std::optional<std::int64_t> impossible_bias_since(std::span<const TrajectoryRow> rows);

}  // namespace limber
