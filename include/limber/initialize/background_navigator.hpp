// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <future>
#include <memory>
#include <optional>

#include "limber/initialize/online_navigator.hpp"

namespace limber {

/// What became of one frame, and where the body was then.
struct BackgroundReport {
  /// as OnlineNavigator::process says it
  OnlineReport online;
  std::optional<PredictedState> state;  ///< at the frame, with its covariance; nothing before the start
};

/// @brief An OnlineNavigator on a thread of its own, for robots whose own thread must not wait: the start
/// solves its window in one call, which takes some tenths of a second. Calls here put into a queue and
/// return.
///
/// Inputs and frames are worked off in the order in which they came: the same bits as by one thread, later
/// only where there was much to do. While the start computes frames pile up; those of one second need some
/// hundredths of a second then. waiting() says how many there are, for who would rather drop some.
///
/// Calls may come from several threads; their order is that of the queue.
class BackgroundNavigator {
 public:
  /// @throws std::invalid_argument as OnlineNavigator
  BackgroundNavigator(const NavigatorOptions& options, const StereoCalibration& calibration,
                      const StartOptions& start = {});
  /// Ends after the frame that is being worked at. The futures of those behind it hold std::future_error.
  ~BackgroundNavigator();
  BackgroundNavigator(const BackgroundNavigator&) = delete;
  BackgroundNavigator& operator=(const BackgroundNavigator&) = delete;

  /// What OnlineNavigator would refuse is left out, and the next frame's future throws that.
  void add_imu(const ImuSample& sample);
  /// As add_imu, in the place of an IMU.
  void add_odometry(const OdometrySample& sample);
  /// @return what becomes of the frame; throws what OnlineNavigator::process throws (a frame that is refused
  ///   changes nothing), or what a sample before it was refused for (the frame is worked at all the same, and
  ///   its report is lost)
  [[nodiscard]] std::future<BackgroundReport> process(StereoFrame frame);

  /// Frames that have not been worked off.
  [[nodiscard]] std::size_t waiting() const;

 private:
  struct Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace limber
