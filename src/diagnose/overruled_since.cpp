// SPDX-License-Identifier: MIT
#include "limber/diagnose/overruled_since.hpp"

#include <algorithm>
#include <cstddef>

#include "diagnose/run_events.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr double kLasts = 3.0;                // [s]
constexpr std::size_t kFewestOverruled = 10;  // of them

}  // namespace

std::optional<std::int64_t> overruled_since(std::span<const FrameReport> frames) {
  std::size_t first = 0, overruled = 0;  // of the shortest stretch that ends here and lasts that long
  for (std::size_t k = 0; k < frames.size(); ++k) {
    overruled += frames[k].gate_overruled ? 1 : 0;
    while (first < k && seconds_between(frames[first + 1].t_ns, frames[k].t_ns) >= kLasts) {
      overruled -= frames[first++].gate_overruled ? 1 : 0;
    }
    const std::span<const FrameReport> stretch = frames.subspan(first, k + 1 - first);
    if (seconds_between(stretch.front().t_ns, stretch.back().t_ns) >= kLasts &&
        stretch.size() >= kFewestOverruled && 2 * overruled > stretch.size()) {
      return std::ranges::find_if(stretch, &FrameReport::gate_overruled)->t_ns;
    }
  }
  return std::nullopt;
}

void add_overruled(RunRecord& record, RunSummary& summary) {
  if (summary.inputs.lost_since_ns || record.motion == MotionModel::kOdometry) {
    return;
  }
  if (const auto since = overruled_since(record.frames)) {
    detail::lose(*since,
                 "most points contradict the rig or the state for seconds, and no sigma since then is true",
                 record, summary.inputs);
  }
}

}  // namespace limber
