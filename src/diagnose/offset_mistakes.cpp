// SPDX-License-Identifier: MIT
#include "limber/diagnose/offset_mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "diagnose/clustered_regression.hpp"
#include "limber/core/angle.hpp"

namespace limber {
namespace {

constexpr double kSurelyOff = 5.0;  // standard deviations of an offset ...
constexpr double kChance = 1e-4;    // ... that chance exceeds as rarely, by Student's law ...
constexpr double kLeastCam1 = 1e-3, kLeastCameras = 3e-3;  // ... and that is at least that large [s]
constexpr double kLeastTurn = 7e-3;  // [rad], of a lens no longer than its image is wide

bool is_off(double size, double sigma, double dof, double least) {
  return size >= least && size > kSurelyOff * sigma && detail::is_rarer_than(kChance, size / sigma, dof);
}

bool is_off(const std::optional<TimeOffset>& offset, double assumed, double least) {
  return offset && is_off(std::abs(offset->seconds - assumed), offset->sigma, offset->dof, least);
}

bool mount_is_off(const SensorOffsets& offsets) {
  return offsets.mount && is_off(offsets.mount->turn.norm(), offsets.mount->sigma, offsets.mount->dof,
                                 kLeastTurn * std::max(1.0, offsets.focal_widths));
}

bool cam1_is_off(const SensorOffsets& offsets) {
  return is_off(offsets.cam1, offsets.assumed_cam1, kLeastCam1);
}

bool cameras_are_off(const SensorOffsets& offsets) {
  return is_off(offsets.cameras, offsets.assumed_cameras, kLeastCameras);
}

/// What epipolar lines say of a rig, whatever trajectory there is: but for vergence and the baseline's
/// length, which depths tell, and with them the trajectory.
HealthVerdict by_lines(const CalibrationState& state) {
  const auto vergence = static_cast<std::size_t>(state.vergence);
  const std::size_t length = vergence == 0 ? 4 : 3;
  HealthVerdict out = state.by_movement;
  for (std::size_t axis = 0; axis < state.axes.size(); ++axis) {
    if (axis != vergence && axis != length) {
      out = worst(out, state.axes[axis]);
    }
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

SensorOffsets sensor_offsets(const StereoCalibration& calibration, std::span<const StereoFrame> frames,
                             std::span<const ImuSample> imu) {
  const auto& assumed = calibration.time_offset_s;
  SensorOffsets out{.cam1 = cam1_time_offset(calibration, frames),
                    .cameras = {},
                    .assumed_cam1 = assumed[1] - assumed[0],
                    .assumed_cameras = assumed[0],
                    .mount = {},
                    .focal_widths = calibration.cam0.fu / calibration.cam0.width};
  if (const auto beside = cameras_beside_imu(calibration, frames, imu)) {
    out.cameras = beside->clock;
    out.mount = beside->mount;
  }
  return out;
}

std::vector<std::string> clock_mistakes(const SensorOffsets& offsets) {
  std::vector<std::string> out;
  if (cam1_is_off(offsets)) {
    out.push_back("time offset: beside cam0, cam1 is taken " + in_words(*offsets.cam1, offsets.assumed_cam1));
  }
  if (cameras_are_off(offsets)) {
    out.push_back("time offset: beside the IMU, the cameras are taken " +
                  in_words(*offsets.cameras, offsets.assumed_cameras));
  }
  return out;
}

std::optional<std::string> mount_mistake(const SensorOffsets& offsets) {
  if (!mount_is_off(offsets)) {
    return std::nullopt;
  }
  const MountTurn& mount = *offsets.mount;
  return fmt::format(
      "mount: beside the IMU, cam0 is turned by {:.2f} ± {:.2f} deg against T_BS (imu-ax {:+.2f}, imu-ay "
      "{:+.2f}, imu-az "
      "{:+.2f} deg; a principal point that is off looks alike): attitude is wrong by more than its sigmas "
      "say, and "
      "positions with it",
      kToDegrees * mount.turn.norm(), kToDegrees * mount.sigma, kToDegrees * mount.turn.x(),
      kToDegrees * mount.turn.y(), kToDegrees * mount.turn.z());
}

std::vector<std::string> offset_mistakes(const SensorOffsets& offsets) {
  std::vector<std::string> out = clock_mistakes(offsets);
  if (auto mount = mount_mistake(offsets)) {
    out.push_back(*std::move(mount));
  }
  return out;
}

HealthVerdict verdict_by_lines(const HealthSummary& health) {
  const HealthVerdict lines = by_lines(health.present);
  return is_wrong(health.verdict) && is_wrong(lines) ? lines : HealthVerdict::kCannotTell;
}

HealthVerdict verdict_beside(const SensorOffsets& offsets, const HealthSummary& health) {
  const bool cam1 = cam1_is_off(offsets), cameras = cameras_are_off(offsets);
  if (!cam1 && !cameras) {
    const bool degraded = mount_is_off(offsets) && health.verdict == HealthVerdict::kOk;
    return degraded ? HealthVerdict::kDegraded : health.verdict;
  }
  return cam1 ? HealthVerdict::kCannotTell : verdict_by_lines(health);
}

}  // namespace limber
