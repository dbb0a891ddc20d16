// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "limber/health/calibration_watch.hpp"

/// @file
/// The rig of one recording against that of another.
namespace limber {

/// What a recording says of its rig at its end, kept for those to come.
struct RigRecord {
  RigParameters theta = RigParameters::Zero();  ///< assumed [rad, m]
  bool metric = true;                           ///< inputs said how long a metre is
  std::int64_t from_ns = 0, to_ns = 0;          ///< first and last frame
  /// what the estimate rests on; deep: points whose depth is known from motion, and their tracks
  std::size_t windows = 0, tracks = 0, points = 0, deep = 0, deep_tracks = 0;
  BetaEstimate estimate;  ///< against `theta`, in plausible errors of it
};

/// What is to be kept of a state that was judged against `theta`.
[[nodiscard]] RigRecord rig_record(const CalibrationState& state, const RigParameters& theta, bool metric);

/// @brief How the rig moved from one recording to the next: true theta now minus true theta before, judged as
/// a calibration is, with what was assumed now as the place to judge it at.
///
/// What the lenses do wrong is in both estimates and cancels in their difference. Their covariances count it
/// twice nevertheless, so that the interval is rather too wide. `ok` says that nothing moved that matters.
/// @note docs/derivations/health.md
[[nodiscard]] CalibrationState change_between(const RigRecord& before, const RigRecord& now,
                                              const Tolerance& tolerance);

}  // namespace limber
