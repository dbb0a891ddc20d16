// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "limber/run/run_recording.hpp"

namespace limber::detail {

/// The samples from there on with the times at which they were taken, as far as the run found out.
[[nodiscard]] std::vector<ImuSample> samples_as_taken(const Recording& recording, const RunRecord& record,
                                                      std::int64_t from_ns);

}  // namespace limber::detail
