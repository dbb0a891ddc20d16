// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "limber/diagnose/run_summary.hpp"
#include "limber/run/run_recording.hpp"

/// @file
/// A rig that is good enough, and not as exact as a method's sigmas take it for.
namespace limber {

/// A part of the rig that a method takes for exact.
struct TrustedPart {
  /// one of ax ... tz, or "baseline"
  std::string name;
  RigParameters along = RigParameters::Zero();  ///< of unit length, in theta: its error is along · delta
  bool is_angle = false;                        ///< [rad], else [m]
};

/// @brief What a run's method takes for exact: all six of `ekf`, what `lcekf` does not constrain. None of the
/// other methods, nor what is estimated or softened, nor a baseline's length that nothing tells.
[[nodiscard]] std::vector<TrustedPart> trusted_parts(const RunOptions& options, MotionModel motion,
                                                     const RigParameters& theta);

/// Trusted parts that are off, in one stretch of a run.
struct TrustedRigOff {
  std::int64_t from_ns = 0, to_ns = 0;  ///< first and last frame of the stretch
  std::string in_words;                 ///< "ty +3.1 ± 0.4 mm", the surest first, three at most
};

/// @brief The stretch of a run's calibration in which it is surest that a trusted part is off, if it is.
///
/// The error of each part by its sigma, Student's t with 24 degrees of freedom, which is what the covariance
/// of a stretch rests on. It counts if a run of an exact rig would show it once in a thousand runs: p < 0.001
/// over the number of parts and stretches. Stretches with fewer than 30 tracks, or of whose tracks fewer have
/// a depth of their own, count for nothing, as they do for the verdict.
/// @param share_of_runs  of exact rigs that would show it, in place of 0.001
[[nodiscard]] std::optional<TrustedRigOff> trusted_rig_off(const HealthSummary& rig,
                                                           const std::vector<TrustedPart>& parts,
                                                           double share_of_runs = 1e-3);

/// @brief Says so of a run, in an event ("trusted rig off") and a note: its sigmas are too small, whatever
/// the verdict is. The same of the scale ("trusted scale off"), where inputs alone show another one: once in
/// a thousand runs, too. Nothing of a run that is lost, or whose rows are not exposed as assumed.
void add_trusted_rig(const RunOptions& options, RunRecord& record, RunSummary& summary);

}  // namespace limber
