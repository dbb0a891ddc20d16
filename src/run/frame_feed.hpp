// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "limber/initialize/sensor_start.hpp"
#include "limber/run/run_recording.hpp"

/// A recording's inputs and frames in the order of time.
namespace limber::detail {

using Clock = std::chrono::steady_clock;

inline double milliseconds(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

/// Feeds inputs in time.
class InputFeed {
 public:
  /// @param clock_step  of the IMU: its samples come with the times at which they were taken
  explicit InputFeed(const SensorData& sensors, const std::optional<StampJump>& clock_step = std::nullopt)
      : sensors_(sensors), clock_step_(clock_step) {}

  /// All samples up to the first one at or after t, to a navigator or a start.
  template <typename Receiver>
  void feed(Receiver& receiver, MotionModel motion, std::int64_t t_ns) {
    switch (motion) {
      case MotionModel::kImu:
        advance(sensors_.imu, t_ns, clock_step_, [&](const ImuSample& s) { receiver.add_imu(s); });
        break;
      case MotionModel::kOdometry:
        advance(sensors_.odometry, t_ns, {}, [&](const OdometrySample& s) { receiver.add_odometry(s); });
        break;
      case MotionModel::kConstantVelocity:
        break;
    }
  }

 private:
  template <typename Sample, typename Add>
  void advance(const std::vector<Sample>& samples, std::int64_t t_ns, const std::optional<StampJump>& jump,
               Add add) {
    while (next_ < samples.size() && newest_ns_ < t_ns) {
      Sample sample = samples[next_++];
      if (const auto taken_ns = taken_at(sample.t_ns, jump)) {
        sample.t_ns = newest_ns_ = *taken_ns;
        add(sample);
      }
    }
  }

  const SensorData& sensors_;
  std::optional<StampJump> clock_step_;
  std::size_t next_ = 0;
  std::int64_t newest_ns_ = std::numeric_limits<std::int64_t>::min();
};

/// A frame that was read, and how long that took.
struct ReadFrame {
  StereoFrame frame;
  double ms = 0.0;
};

inline ReadFrame read_frame(const FrameSource& source, std::size_t n) {
  const auto begin = Clock::now();
  StereoFrame frame = source(n);
  return {std::move(frame), milliseconds(begin, Clock::now())};
}

}  // namespace limber::detail
