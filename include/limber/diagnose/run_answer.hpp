// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "limber/diagnose/run_summary.hpp"

namespace limber {

/// How the answer of a run looks from afar.
enum class AnswerLight : std::uint8_t {
  kGreen,   ///< the calibration is ok
  kYellow,  ///< degraded, or in doubt
  kRed,     ///< decalibrated, or the run is lost
  kGrey     ///< cannot tell, or not judged
};
/// "green", "yellow", "red", "grey".
[[nodiscard]] std::string_view to_string(AnswerLight light);

/// What a run says in one glance: the verdict, why, how good the poses are, and what to do.
struct RunAnswer {
  AnswerLight light = AnswerLight::kGrey;  ///< of the verdict; red where the run is lost
  std::string headline;                    ///< "calibration ok", "lost since 12.3 s"
  std::vector<std::string> sentences;  ///< why; how good the poses are; what was done about the truth's world
  std::string advice;                  ///< what to do
};

/// @param summary  of `record`, with what add_readout added
[[nodiscard]] RunAnswer answer_of(const RunOptions& options, const RunRecord& record,
                                  const RunSummary& summary);

}  // namespace limber
