// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "limber/run/run_recording.hpp"

namespace limber::detail {

/// How long before a frame the samples begin that it needs [ns].
inline constexpr std::int64_t kInputsBefore = 100'000'000;

/// The samples from shortly before the first of the run's last frames on, with the times at which they were
/// taken, as far as the run found out. @param record  with last frames
[[nodiscard]] std::vector<ImuSample> samples_as_taken(const Recording& recording, const RunRecord& record);

}  // namespace limber::detail
