// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <variant>

#include "limber/initialize/sensor_start.hpp"
#include "limber/navigate/navigator.hpp"

namespace limber {

/// What became of one frame, before the start or after it.
struct OnlineReport {
  /// [ns], of the frame
  std::int64_t t_ns = 0;
  /// How far the start has come, and what it still waits for; nothing in the frames after the one that ends
  /// it.
  std::optional<StartReport> start;
  /// What the filter made of the frame; nothing of the frames that the start uses up.
  std::optional<FrameReport> frame;
};

/// @brief A navigator that finds its start: inputs and frames in from the first one on, the state out as soon
/// as there is one. By any method, to the same bits as SensorStart and then Navigator.
///
/// Feed inputs up to (or beyond) a frame's time, then the frame. Until the start is over each frame's report
/// says what is still waited for.
/// With an IMU or without inputs the frames of the start are spent, and the state stands at the last of them.
/// With odometry the first frame is the start, and the filter sees it, too. World: z up, the origin where the
/// body was in the first frame.
///
/// Before the start and after it a sample or frame that is out of order, given twice, hours ahead or not
/// finite is refused (std::invalid_argument), and nothing has changed. A sample older than the last frame
/// comes too late for it: the time that it should have covered was a gap, and from the filter's second frame
/// on the next report counts it (InputFault::kLate). The start begins with the first frame that inputs reach;
/// frames before that are answered by what is missing, and are of no use. One navigator, one thread.
class OnlineNavigator {
 public:
  /// @param calibration  what the filter assumes; never the truth (but see oracle)
  /// @throws std::invalid_argument if options contradict each other or shapes disagree
  OnlineNavigator(const NavigatorOptions& options, const StereoCalibration& calibration,
                  const StartOptions& start = {});

  /// @throws std::invalid_argument as StereoFilter::add_imu
  void add_imu(const ImuSample& sample);
  /// As add_imu, in the place of an IMU.
  void add_odometry(const OdometrySample& sample);

  /// @brief One frame, to the start or to the filter. A call in which the start solves its window takes as
  /// long as many others; BackgroundNavigator is for those who must not wait.
  /// @throws std::invalid_argument as StereoFilter::process
  OnlineReport process(const StereoFrame& frame);

  /// Starts from the sensors anew, as if nothing had come: time may begin anew, too.
  void reset();
  /// @brief Goes on from a known state, with a map or without. Samples of the last minute count on if the
  /// state is not older than all of them; else time begins anew.
  /// @throws std::invalid_argument if shapes disagree or the state is not finite; nothing has changed then
  void reset(const InitialState& initial);

  /// Whether there is a state.
  [[nodiscard]] bool started() const { return navigator_.has_value(); }

  /// Mean and covariance of body, parameters and map after the last frame. Invalidated by the next call.
  /// @throws std::logic_error before the start
  [[nodiscard]] const Estimate& estimate() const { return navigator().estimate(); }
  /// The body at t_ns with the inputs so far, for instance at the rate of the IMU; changes nothing.
  /// @throws std::logic_error before the start
  [[nodiscard]] PredictedState predict(std::int64_t t_ns) const { return navigator().predict(t_ns); }
  /// The door of `oracle`, and of nobody else: the rig as it is from now on, which the filter takes for true.
  /// @throws std::logic_error before the start, and for any other method
  void show_true_rig(const TrueRig& truth);

  /// How much later than taken an IMU's samples are stamped by now, as far as the images showed it [ns]. As
  /// Navigator::clock_offset_ns; while a start goes on that of SensorStart.
  [[nodiscard]] std::int64_t clock_offset_ns() const;

  /// What the alarm made of the last frame; nothing before the start, or if the calibration is not watched.
  [[nodiscard]] std::optional<HealthReport> health() const;
  /// What is known of the calibration; null before the first window is over, or if it is not watched.
  [[nodiscard]] std::shared_ptr<const CalibrationReport> calibration_report() const;
  /// The calibration that is taken for true: what was given, with what has been estimated since the start.
  [[nodiscard]] const StereoCalibration& calibration() const;
  /// What has been learned of it; nothing before the start.
  [[nodiscard]] CalibrationEstimate calibration_estimate() const;
  /// As they were given.
  [[nodiscard]] const NavigatorOptions& options() const { return options_; }

  /// All else that there is to know once started. Invalidated by reset.
  /// @throws std::logic_error before the start
  [[nodiscard]] const Navigator& navigator() const;

 private:
  using Input = std::variant<ImuSample, OdometrySample>;

  template <typename Sample>
  void add(const Sample& sample);
  void check(const Input& input) const;
  [[nodiscard]] bool reaches(std::int64_t t_ns) const;
  StartReport continue_start(const StereoFrame& frame);
  void hand_over(const InitialState& initial, std::deque<Input> inputs);

  NavigatorOptions options_;
  StereoCalibration calibration_;  // as given
  StartOptions start_options_;
  std::deque<Input> inputs_;                   // of the last minute, and all that the start has seen
  std::optional<std::int64_t> last_frame_ns_;  // of the start
  std::optional<SensorStart> start_;           // from the first frame that inputs reach to the hand-over
  std::optional<Navigator> navigator_;         // since
  std::optional<StampJump> clock_step_;        // of the IMU during the start; inputs_ are corrected since
};

}  // namespace limber
