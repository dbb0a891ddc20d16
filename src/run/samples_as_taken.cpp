// SPDX-License-Identifier: MIT
#include "samples_as_taken.hpp"

#include <algorithm>
#include <iterator>

namespace limber::detail {

std::vector<ClockOffset> clock_offsets_in(const RunRecord& record) {
  std::vector<ClockOffset> out;
  for (const FrameReport& frame : record.frames) {
    if (frame.inputs.contradiction && frame.inputs.contradiction->clock_offset_ns) {
      out.push_back({frame.t_ns, *frame.inputs.contradiction->clock_offset_ns});
    }
  }
  return out;
}

std::vector<ImuSample> samples_as_taken(const Recording& recording, const RunRecord& record,
                                        std::int64_t frame_ns) {
  const std::int64_t from_ns = frame_ns - kInputsBefore;
  const std::vector<ClockOffset> offsets = clock_offsets_in(record);
  std::vector<ImuSample> out;
  for (ImuSample sample : recording.imu) {
    const std::int64_t stamp_ns = sample.t_ns;
    const auto taken_ns = taken_at(stamp_ns, record.clock_step_of_start);
    sample.t_ns = taken_ns.value_or(from_ns - 1);
    const auto next = std::ranges::lower_bound(offsets, stamp_ns, {}, &ClockOffset::t_ns);
    sample.t_ns -= next != offsets.begin() ? std::prev(next)->offset_ns : record.start.clock_offset_ns;
    if (sample.t_ns >= from_ns && (out.empty() || sample.t_ns > out.back().t_ns)) {
      out.push_back(sample);
    }
  }
  return out;
}

}  // namespace limber::detail
