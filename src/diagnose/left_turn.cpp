// SPDX-License-Identifier: MIT
#include "diagnose/left_turn.hpp"

#include <algorithm>

#include "limber/core/time.hpp"
#include "measure/two_views.hpp"

namespace limber::detail {
namespace {

constexpr double kTurn = 0.2;  // [s]

}  // namespace

std::optional<std::size_t> frame_after(std::span<const StereoFrame> frames, std::size_t n, double seconds) {
  const auto later = frames.subspan(n);
  const auto end = std::ranges::lower_bound(later, seconds, {}, [&](const StereoFrame& frame) {
    return seconds_between(frames[n].t_ns, frame.t_ns);
  });
  if (end == later.end() || seconds_between(frames[n].t_ns, end->t_ns) > 2.0 * seconds) {
    return std::nullopt;
  }
  return n + static_cast<std::size_t>(end - later.begin());
}

std::vector<Turn> left_turns(const StereoCalibration& calibration, std::span<const StereoFrame> frames,
                             std::int64_t origin_ns) {
  std::vector<Turn> out;
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const auto last = frame_after(frames, n, kTurn);
    const auto motion = last ? left_motion(calibration, frames[n], frames[*last]) : std::nullopt;
    if (motion) {
      const double begin = seconds_between(origin_ns, frames[n].t_ns),
                   end = seconds_between(origin_ns, frames[*last].t_ns);
      out.push_back({begin, end, Eigen::Vector3d(motion->turn / (end - begin)), motion->confusion});
    }
  }
  return out;
}

}  // namespace limber::detail
