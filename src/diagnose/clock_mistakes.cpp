// SPDX-License-Identifier: MIT
#include "limber/diagnose/clock_mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "diagnose/clustered_regression.hpp"

namespace limber {
namespace {

constexpr double kSurely = 5.0;   // standard deviations of an offset ...
constexpr double kChance = 1e-4;  // ... that chance exceeds as rarely, by Student's law ...
constexpr double kLeastCam1 = 1e-3, kLeastCameras = 3e-3;  // ... and that is at least that large [s]

bool is_off(const std::optional<TimeOffset>& offset, double assumed, double least) {
  if (!offset || std::abs(offset->seconds - assumed) < least) {
    return false;
  }
  const double sigmas = std::abs(offset->seconds - assumed) / offset->sigma;
  return sigmas > kSurely && detail::is_rarer_than(kChance, sigmas, offset->dof);
}

bool cam1_is_off(const ClockOffsets& clocks) { return is_off(clocks.cam1, clocks.assumed_cam1, kLeastCam1); }

bool cameras_are_off(const ClockOffsets& clocks) {
  return is_off(clocks.cameras, clocks.assumed_cameras, kLeastCameras);
}

/// What epipolar lines say of a rig, whatever trajectory there is: but for vergence and the baseline's
/// length, which depths tell, and with them the trajectory.
HealthVerdict by_lines(const CalibrationState& state) {
  constexpr std::array<std::size_t, 4> kSeenByLines = {0, 2, 4, 5};
  HealthVerdict out = state.by_movement;
  for (const std::size_t axis : kSeenByLines) {
    out = worst(out, state.axes[axis]);
  }
  return out;
}

/// "20.0 ± 0.3 ms later than stamped"
std::string in_words(const TimeOffset& offset, double assumed) {
  const std::string than = assumed == 0.0 ? "" : fmt::format(", and {:.1f} ms are assumed", 1e3 * assumed);
  return fmt::format("{:.1f} ± {:.1f} ms {} than stamped{}: it looks like a rig that bends while it moves",
                     1e3 * std::abs(offset.seconds), 1e3 * offset.sigma,
                     offset.seconds > 0.0 ? "later" : "earlier", than);
}

}  // namespace

ClockOffsets clock_offsets(const StereoCalibration& calibration, std::span<const StereoFrame> frames,
                           std::span<const ImuSample> imu) {
  const auto& assumed = calibration.time_offset_s;
  return {cam1_time_offset(calibration, frames), camera_time_offset(calibration, frames, imu),
          assumed[1] - assumed[0], assumed[0]};
}

std::vector<std::string> clock_mistakes(const ClockOffsets& clocks) {
  std::vector<std::string> out;
  if (cam1_is_off(clocks)) {
    out.push_back("time offset: beside cam0, cam1 is taken " + in_words(*clocks.cam1, clocks.assumed_cam1));
  }
  if (cameras_are_off(clocks)) {
    out.push_back("time offset: beside the IMU, the cameras are taken " +
                  in_words(*clocks.cameras, clocks.assumed_cameras));
  }
  return out;
}

HealthVerdict verdict_beside(const ClockOffsets& clocks, const HealthSummary& health) {
  const bool cam1 = cam1_is_off(clocks), cameras = cameras_are_off(clocks);
  if (!cam1 && !cameras) {
    return health.verdict;
  }
  const HealthVerdict lines = by_lines(health.present);
  return !cam1 && is_wrong(health.verdict) && is_wrong(lines) ? lines : HealthVerdict::kCannotTell;
}

}  // namespace limber
