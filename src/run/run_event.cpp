// SPDX-License-Identifier: MIT
#include "limber/run/run_event.hpp"

namespace limber {

std::string to_string(RunEventKind kind) {
  switch (kind) {
    case RunEventKind::kNoInputs:
      return "no inputs";
    case RunEventKind::kGap:
      return "gap";
    case RunEventKind::kStuck:
      return to_string(InputFault::kStuck);
    case RunEventKind::kSpike:
      return to_string(InputFault::kSpike);
    case RunEventKind::kSaturated:
      return to_string(InputFault::kSaturated);
    case RunEventKind::kImpossible:
      return to_string(InputFault::kImpossible);
    case RunEventKind::kLate:
      return to_string(InputFault::kLate);
    case RunEventKind::kContradicted:
      return "contradicted";
    case RunEventKind::kClockStepped:
      return "clock stepped";
    case RunEventKind::kNoPoints:
      return "no points";
    case RunEventKind::kGateOverruled:
      return "gate overruled";
    case RunEventKind::kMostMove:
      return "most points move";
    case RunEventKind::kMostMismatched:
      return "most points mismatched";
    case RunEventKind::kLedAstray:
      return "led astray";
    case RunEventKind::kLeapt:
      return "leapt";
    case RunEventKind::kStateContradicted:
      return "state contradicted";
    case RunEventKind::kReset:
      return "reset";
    case RunEventKind::kTrustedRigOff:
      return "trusted rig off";
    case RunEventKind::kTrustedScaleOff:
      return "trusted scale off";
    case RunEventKind::kBiasMoved:
      return "bias moved";
    case RunEventKind::kImpossibleBias:
      return "impossible bias";
    case RunEventKind::kMisled:
      return "misled";
  }
  return {};
}

RunEventKind event_of(InputFault fault) {
  switch (fault) {
    case InputFault::kStuck:
      return RunEventKind::kStuck;
    case InputFault::kSpike:
      return RunEventKind::kSpike;
    case InputFault::kSaturated:
      return RunEventKind::kSaturated;
    case InputFault::kImpossible:
      return RunEventKind::kImpossible;
    case InputFault::kLate:
      break;
  }
  return RunEventKind::kLate;
}

}  // namespace limber
