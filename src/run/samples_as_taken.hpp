// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "limber/run/run_recording.hpp"

namespace limber::detail {

/// How long before a frame the samples begin that it needs [ns].
inline constexpr std::int64_t kInputsBefore = 100'000'000;

/// How much later than taken samples are stamped from that frame on.
struct ClockOffset {
  std::int64_t t_ns, offset_ns;
};

/// Those that the filter found, in order of time.
[[nodiscard]] std::vector<ClockOffset> clock_offsets_in(const RunRecord& record);

/// The samples from shortly before a frame on, with the times at which they were taken, as far as the run
/// found out.
[[nodiscard]] std::vector<ImuSample> samples_as_taken(const Recording& recording, const RunRecord& record,
                                                      std::int64_t frame_ns);

}  // namespace limber::detail
