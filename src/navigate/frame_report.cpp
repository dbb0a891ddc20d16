// SPDX-License-Identifier: MIT
#include "limber/navigate/frame_report.hpp"

namespace limber {

ParameterSet told_parameters(const CalibrationEstimate& estimate) {
  ParameterSet out = estimate.parameters;
  for (std::size_t k = 0; estimate.trusts_rig && k < static_cast<std::size_t>(kBlockSize); ++k) {
    out[k] = false;
  }
  return out;
}

std::string to_string(InputStatus status) {
  switch (status) {
    case InputStatus::kNotNeeded:
      return "not needed";
    case InputStatus::kSound:
      return "sound";
    case InputStatus::kFaulty:
      return "faulty";
    case InputStatus::kGap:
      return "gap";
    case InputStatus::kContradicted:
      return "contradicted";
    case InputStatus::kNone:
      break;
  }
  return "none";
}

std::string to_string(UpdateStatus status) {
  switch (status) {
    case UpdateStatus::kUpdated:
      return "updated";
    case UpdateStatus::kEmpty:
      return "no points";
    case UpdateStatus::kSingularInnovation:
      break;
  }
  return "singular";
}

std::string to_string(InputFault fault) {
  switch (fault) {
    case InputFault::kStuck:
      return "stuck";
    case InputFault::kSpike:
      return "spike";
    case InputFault::kSaturated:
      return "saturated";
    case InputFault::kImpossible:
      return "impossible";
    case InputFault::kLate:
      break;
  }
  return "late";
}

InputReport report_on(const InputBuffer& inputs, const InputFaultCounts& faults, std::int64_t begin_ns,
                      std::int64_t end_ns) {
  InputReport out;
  out.faults = faults;
  out.gap_s = inputs.longest_gap_s(begin_ns, end_ns);
  out.status = inputs.empty()     ? InputStatus::kNone
               : out.gap_s > 0.0  ? InputStatus::kGap
               : out.faults.any() ? InputStatus::kFaulty
                                  : InputStatus::kSound;
  return out;
}

}  // namespace limber
