// SPDX-License-Identifier: MIT
#include "diagnose/accelerations.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "diagnose/gyro_attitude.hpp"
#include "diagnose/left_turn.hpp"
#include "limber/core/time.hpp"
#include "limber/initialize/stereo_motion.hpp"

namespace limber::detail {
namespace {

using Eigen::Vector3d;
using ByMount = Eigen::Matrix<double, 3, 9>;

constexpr double kHalf = 0.5;        // between two of three frames [s]
constexpr double kEvery = 0.2;       // [s]
constexpr double kAround = 1.5;      // [s]
constexpr std::size_t kFewest = 10;  // around a time

/// Three frames, and where the body was in them.
struct Instant {
  double t_s = 0.0;  // of the second frame, since the first sample of the IMU
  Vector3d camera;   // acceleration, in the gyro's first axes
  ByMount by_mount;
};

/// Up to a factor, what counts of an acceleration in the difference of two mean velocities: a triangle over
/// the three times.
double weight(const std::array<double, 3>& t, double at) {
  return std::max(0.0, at < t[1] ? (at - t[0]) / (t[1] - t[0]) : (t[2] - at) / (t[2] - t[1]));
}

std::optional<ByMount> by_mount(std::span<const ImuSample> imu, const GyroAttitude& gyro,
                                const std::array<double, 3>& t) {
  const auto time_of = [&](const ImuSample& s) { return seconds_between(imu.front().t_ns, s.t_ns); };
  ByMount sum = ByMount::Zero();
  double weights = 0.0;
  const auto end = std::ranges::lower_bound(imu, t[2], {}, time_of);
  for (auto sample = std::ranges::lower_bound(imu, t[0], {}, time_of); sample != end; ++sample) {
    const double at = time_of(*sample), w = weight(t, at);
    const auto R = gyro.at(at);
    if (!R) {
      return std::nullopt;
    }
    for (Eigen::Index c = 0; c < 3; ++c) {
      sum.middleCols<3>(3 * c) += w * sample->accel_imu(c) * *R;
    }
    weights += w;
  }
  return weights > 0.0 ? std::optional(ByMount(sum / weights)) : std::nullopt;
}

std::optional<Instant> instant(const StereoCalibration& calibration, std::span<const StereoFrame> frames,
                               std::span<const ImuSample> imu, const GyroAttitude& gyro, std::size_t n) {
  const auto second = frame_after(frames, n, kHalf);
  const auto third = second ? frame_after(frames, *second, kHalf) : std::nullopt;
  if (!third) {
    return std::nullopt;
  }
  const std::array<StereoFrame, 3> three = {frames[n], frames[*second], frames[*third]};
  const std::vector<StampedPose> motion = stereo_motion(three, calibration);
  std::array<double, 3> t{};
  for (std::size_t k = 0; k < 3; ++k) {
    t[k] = seconds_between(imu.front().t_ns, three[k].t_ns);
  }
  const auto R = gyro.at(t[0]);
  const auto force = by_mount(imu, gyro, t);
  if (motion.size() < 3 || !R || !force) {
    return std::nullopt;
  }
  const Vector3d before = (motion[1].T_world_body.p - motion[0].T_world_body.p) / (t[1] - t[0]);
  const Vector3d behind = (motion[2].T_world_body.p - motion[1].T_world_body.p) / (t[2] - t[1]);
  return Instant{t[1], *R * (behind - before) / (0.5 * (t[2] - t[0])), *force};
}

/// Less the mean of those around.
std::optional<Acceleration> centred(const std::vector<Instant>& all, const Instant& one) {
  Acceleration mean{one.t_s, Vector3d::Zero(), ByMount::Zero()};
  std::size_t around = 0;
  for (const Instant& other : all) {
    if (std::abs(other.t_s - one.t_s) <= kAround) {
      mean.camera += other.camera;
      mean.by_mount += other.by_mount;
      ++around;
    }
  }
  if (around < kFewest) {
    return std::nullopt;
  }
  const double share = 1.0 / static_cast<double>(around);
  return Acceleration{one.t_s, one.camera - share * mean.camera, one.by_mount - share * mean.by_mount};
}

}  // namespace

std::vector<Acceleration> accelerations(const StereoCalibration& calibration,
                                        std::span<const StereoFrame> frames, std::span<const ImuSample> imu) {
  const GyroAttitude gyro(imu);
  std::vector<Instant> instants;
  for (std::size_t n = 0; n < frames.size();) {
    if (auto one = instant(calibration, frames, imu, gyro, n)) {
      instants.push_back(*one);
    }
    n = std::max(n + 1, frame_after(frames, n, kEvery).value_or(n + 1));
  }
  std::vector<Acceleration> out;
  for (const Instant& one : instants) {
    if (auto less_mean = centred(instants, one)) {
      out.push_back(*less_mean);
    }
  }
  return out;
}

}  // namespace limber::detail
