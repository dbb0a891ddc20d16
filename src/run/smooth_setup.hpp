// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "limber/run/smooth_recording.hpp"

/// What everything needs that hands a recording, or a part of it, to the smoother.
namespace limber::detail {

/// A filter's states, where the iteration begins.
struct Guess {
  RunRecord record;
  std::vector<NavigationState> states;
  std::vector<ImuSample> imu;  ///< when they were taken, as far as the run found out
};

/// Asks the source for each frame once and keeps it.
class KeptFrames {
 public:
  explicit KeptFrames(const FrameSource& source) : source_(source) {}
  StereoFrame operator()(std::size_t n);
  /// Those from `first_ns` on.
  [[nodiscard]] std::vector<StereoFrame> from(std::int64_t first_ns) const;

 private:
  const FrameSource& source_;
  std::vector<StereoFrame> frames_;
};

/// Runs a filter over the recording.
[[nodiscard]] Guess guess_by(Method method, const Recording& recording, RunOptions options,
                             KeptFrames& frames, const std::function<void(std::size_t)>& progress);

/// @brief A start for which nothing is known but the choice of the world's axes and plausible biases: it was
/// made from the same pixels and samples.
[[nodiscard]] InitialState without_data(const NavigationState& first, MotionModel motion);

[[nodiscard]] SmootherOptions smoother_options(const SensorData& sensors, const SmoothOptions& options,
                                               const RunSetup& setup, std::vector<std::string>& notes);

/// Makes a smoother's IMU as noisy as a filter has learned that it is, with a note where that is worth one.
void take_imu_noise(const std::optional<ImuNoiseFactors>& learned, SmootherOptions& how,
                    std::vector<std::string>& notes);

}  // namespace limber::detail
