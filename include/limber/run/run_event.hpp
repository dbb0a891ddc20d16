// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "limber/predict/input_checks.hpp"

namespace limber {

/// What was wrong with the inputs or the filter for a while.
enum class RunEventKind {
  kNoInputs,           ///< no sample had come yet
  kGap,                ///< no usable sample for a while
  kStuck,              ///< samples, see InputFault
  kSpike,              ///< the same
  kSaturated,          ///< the same
  kImpossible,         ///< the same
  kLate,               ///< the same
  kContradicted,       ///< images contradict the inputs
  kClockStepped,       ///< that of the IMU
  kNoPoints,           ///< none could be used
  kGateOverruled,      ///< most points contradict the rig or the state
  kMostMove,           ///< most points move, and were left out
  kMostMismatched,     ///< most points agree on nothing, and were left out
  kLedAstray,          ///< corrections that were not made
  kLeapt,              ///< the body, by many of its sigmas
  kStateContradicted,  ///< by most points, for long
  kReset,              ///< the filter began anew
  kTrustedRigOff,      ///< a method trusts what points contradict
  kTrustedScaleOff,    ///< the same of the baseline's length
  kBiasMoved,          ///< further than it may
  kImpossibleBias,     ///< no IMU has it
  kMisled,             ///< an input failed, seen late or by other tests
};

/// The word of summary.json: "gap", "clock stepped", ...
[[nodiscard]] std::string to_string(RunEventKind kind);
/// The event of samples that have a fault.
[[nodiscard]] RunEventKind event_of(InputFault fault);

/// Something that was wrong with the inputs or the filter for a while.
struct RunEvent {
  /// what it was
  RunEventKind kind = RunEventKind::kGap;
  /// first and last frame with it [ns]
  std::int64_t from_ns = 0, to_ns = 0;
  std::size_t frames = 0, samples = 0;  ///< samples: those with the fault; zero where it has none
  double longest_s = 0.0;               ///< gap: the longest time without a sample
  double clock_offset_s = 0.0;  ///< clock stepped: how much later than taken samples are stamped since
};

}  // namespace limber
