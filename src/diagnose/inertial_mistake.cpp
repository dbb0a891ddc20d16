// SPDX-License-Identifier: MIT
// Images and IMU that contradict each other, in words.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <vector>

#include "limber/core/angle.hpp"
#include "limber/diagnose/offset_mistakes.hpp"

namespace limber {
namespace {

constexpr double kSure = 12.0, kSureOfGyro = 20.0;         // chi-square over degrees of freedom
constexpr double kExplainsAlike = 0.4;                     // of what explains most
constexpr double kNoisierGyro = 5.0, kNoisierAccel = 3.0;  // than stated, and learned

/// From where on an offset is more than what a lens model leaves.
double least_of(InertialFactor factor, const SensorOffsets& offsets) {
  const double narrower = std::max(1.0, offsets.focal_widths);
  switch (factor) {
    case InertialFactor::kMountTurn:
      return 7e-3 * narrower;
    case InertialFactor::kLeverArm:
      return 0.03 * narrower;
    case InertialFactor::kAccelScale:
    case InertialFactor::kAccelScales:
      return 5e-3;
    case InertialFactor::kGyroScale:
      return std::max(5e-3, 2e-3 * offsets.confusion);
    case InertialFactor::kAccelTurn:
      return 9e-3;
    case InertialFactor::kClock:
      break;
  }
  return 3e-3;
}

/// Beyond, a linearisation says nothing; a gyro at rest, whose samples are noise, would best not be there at
/// all.
double most_of(InertialFactor factor) {
  switch (factor) {
    case InertialFactor::kLeverArm:
      return 5.0;
    case InertialFactor::kMountTurn:
    case InertialFactor::kAccelTurn:
      return 0.35;
    case InertialFactor::kAccelScale:
    case InertialFactor::kAccelScales:
    case InertialFactor::kGyroScale:
    case InertialFactor::kClock:
      break;
  }
  return 0.2;
}

bool is_sure(const InertialOffset& offset, const SensorOffsets& offsets) {
  const double asked = offset.of == InertialFactor::kGyroScale ? kSureOfGyro : kSure;
  const double size = offset.value.norm();
  return offset.sureness > asked && size >= least_of(offset.of, offsets) && size <= most_of(offset.of);
}

std::string axes_in_words(const char* what, double unit, const Eigen::Vector3d& value,
                          const char* unit_name) {
  return fmt::format("imu-{0}x {1:+.3f}, imu-{0}y {2:+.3f}, imu-{0}z {3:+.3f} {4}", what, unit * value.x(),
                     unit * value.y(), unit * value.z(), unit_name);
}

std::string in_words(const InertialOffset& offset) {
  const Eigen::Vector3d& value = offset.value;
  const double size = value.norm();
  switch (offset.of) {
    case InertialFactor::kMountTurn:
      return fmt::format("cam0 were turned by {:.2f} ± {:.2f} deg against T_BS ({})", kToDegrees * size,
                         kToDegrees * offset.sigma, axes_in_words("a", kToDegrees, value, "deg"));
    case InertialFactor::kLeverArm:
      return fmt::format("cam0 stood {:.3f} ± {:.3f} m from where T_BS puts it ({})", size, offset.sigma,
                         axes_in_words("t", 1.0, value, "m"));
    case InertialFactor::kAccelScale:
      return fmt::format("the accelerometer showed {:.1f} ± {:.1f} % too {}", 100.0 * size,
                         100.0 * offset.sigma, value.x() > 0.0 ? "little" : "much");
    case InertialFactor::kAccelScales:
      return fmt::format(
          "the accelerometer's axes showed {:+.1f}, {:+.1f}, {:+.1f} % too much (x, y, z; together {:.1f} ± "
          "{:.1f} %)",
          -100.0 * value.x(), -100.0 * value.y(), -100.0 * value.z(), 100.0 * size, 100.0 * offset.sigma);
    case InertialFactor::kAccelTurn:
      return fmt::format("the accelerometer were turned by {:.2f} ± {:.2f} deg against the gyro",
                         kToDegrees * size, kToDegrees * offset.sigma);
    case InertialFactor::kGyroScale:
      return fmt::format("the gyro showed {0:.2f} ± {1:.2f} % too {2}, or a focal length were too {3}",
                         100.0 * size, 100.0 * offset.sigma, value.x() > 0.0 ? "little" : "much",
                         value.x() > 0.0 ? "short" : "long");
    case InertialFactor::kClock:
      break;
  }
  return {};
}

bool is_noise_of_gyro(const ImuNoiseFactors& learned) {
  return learned.gyro >= kNoisierGyro && learned.accel < kNoisierAccel;
}

using Told = std::vector<const InertialOffset*>;

bool all_of(const Told& told, std::initializer_list<InertialFactor> factors) {
  return std::ranges::all_of(
      told, [&](const InertialOffset* o) { return std::ranges::find(factors, o->of) != factors.end(); });
}

/// Whether what the run has learned of the IMU's noise is as large as the mistake: only such noise is in
/// sigmas. No noise is what a scale does to all lengths.
bool noise_holds(const Told& told, const ImuNoiseFactors& learned) {
  return (all_of(told, {InertialFactor::kAccelTurn}) && learned.accel >= kNoisierAccel) ||
         (all_of(told, {InertialFactor::kGyroScale}) && is_noise_of_gyro(learned));
}

/// Those that are sure and explain most, or nearly as much; none where a clock explains more that is farther
/// off than the one beside which all are asked, nor what is named already.
Told explanations(const SensorOffsets& offsets) {
  const std::vector<InertialOffset>& all = offsets.inertial->offsets;
  Told out;
  if (all.empty()) {
    return out;
  }
  const auto beside_a_clock = [](const InertialOffset& offset) {
    const bool counts = offset.of != InertialFactor::kClock || offset.value.norm() > kLeastClock;
    return counts ? offset.sureness : 0.0;
  };
  const InertialOffset& most = *std::ranges::max_element(all, {}, beside_a_clock);
  const bool named = (most.of == InertialFactor::kMountTurn && mount_mistake(offsets)) ||
                     (most.of == InertialFactor::kGyroScale && turn_scale_mistake(offsets));
  if (most.of == InertialFactor::kClock || named) {
    return out;
  }
  for (const InertialOffset& offset : all) {
    const bool alike = offset.sureness >= kExplainsAlike * most.sureness;
    if (alike && offset.of != InertialFactor::kClock && is_sure(offset, offsets)) {
      out.push_back(&offset);
    }
  }
  return out;
}

std::optional<OffsetMistake> unexplained(const InertialCheck& check) {
  if (check.stretches > 0 || check.unexplained == 0 || !check.contradicted) {
    return std::nullopt;
  }
  return OffsetMistake{
      "inertial: images and IMU contradict each other, and no motion explains both: axes or "
      "units of the IMU, or T_BS, are far off",
      kMountAdvice};
}

const char* advice_on(const Told& told) {
  if (all_of(told, {InertialFactor::kAccelTurn, InertialFactor::kAccelScale, InertialFactor::kAccelScales})) {
    return kAccelAdvice;
  }
  return all_of(told, {InertialFactor::kGyroScale}) ? kFocalAdvice : kInertialAdvice;
}

}  // namespace

bool turns_are_in_sigmas(const InertialCheck& check) {
  const bool contradicted = std::ranges::any_of(check.offsets, [](const InertialOffset& offset) {
    return offset.of == InertialFactor::kGyroScale && offset.sureness > kSureOfGyro;
  });
  return !contradicted || is_noise_of_gyro(check.learned);
}

std::optional<OffsetMistake> inertial_mistake(const SensorOffsets& offsets) {
  if (!offsets.inertial || !clock_mistakes(offsets).empty()) {
    return std::nullopt;
  }
  const Told told = explanations(offsets);
  if (told.empty()) {
    return unexplained(*offsets.inertial);
  }
  std::string as;
  for (const InertialOffset* offset : told) {
    as += (as.empty() ? "" : ", or ") + in_words(*offset);
  }
  const char* const advice = advice_on(told);
  const bool holds = noise_holds(told, offsets.inertial->learned);
  return OffsetMistake{
      fmt::format("inertial: images and IMU contradict each other as if {}{}{}", as,
                  advice == kInertialAdvice ? ", or as a principal point that is off would have it" : "",
                  holds ? "" : ": poses are wrong by more than their sigmas say"),
      advice, holds};
}

}  // namespace limber
