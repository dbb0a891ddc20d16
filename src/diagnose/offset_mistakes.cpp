// SPDX-License-Identifier: MIT
#include "limber/diagnose/offset_mistakes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "diagnose/clustered_regression.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/time.hpp"
#include "run/samples_as_taken.hpp"

namespace limber {
namespace {

constexpr double kSurelyOff = 5.0;   // standard deviations of an offset ...
constexpr double kChance = 1e-4;     // ... that chance exceeds as rarely, by Student's law ...
constexpr double kLeastCam1 = 1e-3;  // ... and that is at least that large [s]
constexpr const char* kBesideImu = "time offset: beside the IMU, the cameras are taken ";
constexpr double kLeastExcess = 5e-3;  // of turns
constexpr double kScaleOfLens = 2e-3;  // times the confusion: what a lens model leaves
constexpr double kAsSure = 0.8;        // of the surest factor: explains it as well
constexpr double kLeastTurn = 7e-3;    // [rad], of a lens no longer than its image is wide

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
  return is_off(offsets.cameras, offsets.assumed_cameras + offsets.corrected_cameras, kLeastClock);
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
std::string in_words(const TimeOffset& offset) {
  return fmt::format("{:.1f} ± {:.1f} ms {} than stamped", 1e3 * std::abs(offset.seconds), 1e3 * offset.sigma,
                     offset.seconds > 0.0 ? "later" : "earlier");
}

/// "20.0 ± 0.3 ms later than stamped, and 5.0 ms are assumed: ..."
std::string mistake_in_words(const TimeOffset& offset, double assumed) {
  const std::string than = assumed == 0.0 ? "" : fmt::format(", and {:.1f} ms are assumed", 1e3 * assumed);
  return in_words(offset) + than + ": it looks like a rig that bends while it moves";
}

double sureness(const TurnScale& scale) { return std::abs(scale.excess) / scale.sigma; }

/// "a focal length that is too long"
std::string in_words(TurnFactor factor, double excess) {
  const char* const size = excess < 0.0 ? "large" : "small";
  switch (factor) {
    case TurnFactor::kFocalLength:
      return fmt::format("a focal length that is too {}", excess < 0.0 ? "long" : "short");
    case TurnFactor::kGyro:
      return fmt::format("a scale of the gyro that is too {}", size);
    case TurnFactor::kGyroX:
    case TurnFactor::kGyroY:
    case TurnFactor::kGyroZ:
      break;
  }
  return fmt::format("a scale of the gyro's {} axis that is too {}",
                     "xyz"[static_cast<int>(factor) - static_cast<int>(TurnFactor::kGyroX)], size);
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
                    .focal_widths = calibration.cam0.fu / calibration.cam0.width,
                    .scales = {}};
  if (const auto beside = cameras_beside_imu(calibration, frames, imu)) {
    out.cameras = beside->clock;
    out.mount = beside->mount;
    out.scales = beside->scales;
    out.confusion = beside->confusion;
  }
  return out;
}

double corrected_clock(const RunRecord& record) {
  if (record.clock_step_of_start) {
    return 0.0;
  }
  const double of_start = to_seconds(record.start.clock_offset_ns);
  double out = of_start;
  for (const detail::ClockOffset& found : detail::clock_offsets_in(record)) {
    out = to_seconds(found.offset_ns);
    if (std::abs(out - of_start) > kLeastClock) {
      return 0.0;
    }
  }
  return out;
}

std::optional<std::string> imu_clock_mistake(const SensorOffsets& offsets) {
  if (!cameras_are_off(offsets)) {
    return std::nullopt;
  }
  return std::string(kBesideImu) +
         mistake_in_words(*offsets.cameras, offsets.assumed_cameras + offsets.corrected_cameras);
}

std::optional<std::string> corrected_clock_in_words(const SensorOffsets& offsets) {
  if (cameras_are_off(offsets) || !is_off(offsets.cameras, offsets.assumed_cameras, kLeastClock)) {
    return std::nullopt;
  }
  return kBesideImu + in_words(*offsets.cameras) + ", which is corrected (--imu-clock learned)";
}

std::vector<std::string> clock_mistakes(const SensorOffsets& offsets) {
  std::vector<std::string> out;
  if (cam1_is_off(offsets)) {
    out.push_back("time offset: beside cam0, cam1 is taken " +
                  mistake_in_words(*offsets.cam1, offsets.assumed_cam1));
  }
  if (auto of_imu = imu_clock_mistake(offsets)) {
    out.push_back(*std::move(of_imu));
  }
  return out;
}

std::optional<OffsetMistake> mount_mistake(const SensorOffsets& offsets) {
  if (!mount_is_off(offsets)) {
    return std::nullopt;
  }
  const MountTurn& mount = *offsets.mount;
  return OffsetMistake{
      fmt::format(
          "mount: beside the IMU, cam0 is turned by {:.2f} ± {:.2f} deg against T_BS (imu-ax {:+.2f}, imu-ay "
          "{:+.2f}, imu-az {:+.2f} deg; a principal point, or axes of the gyro, that are off look "
          "alike): attitude is wrong by more than its sigmas say, and positions with it",
          kToDegrees * mount.turn.norm(), kToDegrees * mount.sigma, kToDegrees * mount.turn.x(),
          kToDegrees * mount.turn.y(), kToDegrees * mount.turn.z()),
      kMountAdvice};
}

std::string_view to_string(TurnFactor factor) {
  constexpr std::array<std::string_view, 5> kNames = {"focal length", "gyro", "gyro x", "gyro y", "gyro z"};
  return kNames[static_cast<std::size_t>(factor)];
}

std::optional<TurnScale> surest_scale(const SensorOffsets& offsets) {
  const auto surest = std::ranges::max_element(offsets.scales, {}, sureness);
  return surest == offsets.scales.end() ? std::nullopt : std::optional(*surest);
}

std::optional<OffsetMistake> turn_scale_mistake(const SensorOffsets& offsets) {
  const auto scale = surest_scale(offsets);
  const double least = std::max(kLeastExcess, kScaleOfLens * offsets.confusion);
  if (!scale || !is_off(std::abs(scale->excess), scale->sigma, scale->dof, least)) {
    return std::nullopt;
  }
  std::string explained;
  bool by_focal_length = false;
  for (const TurnScale& one : offsets.scales) {
    if (sureness(one) >= kAsSure * sureness(*scale)) {
      explained += (explained.empty() ? "" : ", or ") + in_words(one.of, one.excess);
      by_focal_length = by_focal_length || one.of == TurnFactor::kFocalLength;
    }
  }
  return OffsetMistake{
      fmt::format("turns: the cameras turn by {:.2f} ± {:.2f} % {} than the gyro says, as {} would have it",
                  100.0 * std::abs(scale->excess), 100.0 * scale->sigma,
                  scale->excess > 0.0 ? "more" : "less", explained),
      by_focal_length ? kFocalAdvice : kGyroScaleAdvice,
      offsets.inertial && turns_are_in_sigmas(*offsets.inertial)};
}

std::vector<OffsetMistake> camera_imu_mistakes(const SensorOffsets& offsets) {
  std::vector<OffsetMistake> out;
  for (auto mistake : {turn_scale_mistake(offsets), mount_mistake(offsets), inertial_mistake(offsets)}) {
    if (mistake) {
      out.push_back(*std::move(mistake));
    }
  }
  return out;
}

std::vector<std::string> offset_mistakes(const SensorOffsets& offsets) {
  std::vector<std::string> out = clock_mistakes(offsets);
  for (OffsetMistake& mistake : camera_imu_mistakes(offsets)) {
    out.push_back(std::move(mistake.words));
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
    const bool degraded = !camera_imu_mistakes(offsets).empty() && health.verdict == HealthVerdict::kOk;
    return degraded ? HealthVerdict::kDegraded : health.verdict;
  }
  return cam1 ? HealthVerdict::kCannotTell : verdict_by_lines(health);
}

}  // namespace limber
