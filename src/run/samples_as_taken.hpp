// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "limber/run/run_recording.hpp"

namespace limber::detail {

/// How long before a frame the samples begin that it needs [ns].
inline constexpr std::int64_t kInputsBefore = 100'000'000;

/// The samples from shortly before a frame on, with the times at which they were taken, as far as the run
/// found out.
[[nodiscard]] std::vector<ImuSample> samples_as_taken(const Recording& recording, const RunRecord& record,
                                                      std::int64_t frame_ns);

}  // namespace limber::detail
