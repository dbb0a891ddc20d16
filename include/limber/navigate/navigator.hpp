// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "limber/health/calibration_watch.hpp"
#include "limber/health/health_monitor.hpp"
#include "limber/navigate/stereo_filter.hpp"

namespace limber {

/// @brief Stereo navigation for a rig that bends, by any method: inputs in, frames in, state out.
///
/// Feed inputs up to (or beyond) a frame's time, then the frame. One navigator, one thread.
///
/// `adaptive` is more than one filter. It trusts the rig as `ekf` does as long as two alarms are silent: one
/// looks at its own innovations, which are sharp where the rig moves under a known map; the other belongs to
/// a parallel constrained filter (lcekf), which sees the same inputs and which no calibration can lead
/// astray. When the first rejects, the filter goes back to a checkpoint from before the window in which it
/// happened and comes again with theta in doubt; when the second does, it takes over the parallel filter's
/// state. From then on the filter learns how much theta stays wrong and how much of it is fresh in every
/// frame. Where nothing but a young map fixes the scale, neither could be learned: there it goes on trusting
/// the rig, and the health report says so. Going back replays some seconds, a few frames at a time: until
/// that has caught up the parallel filter answers.
/// @note docs/derivations/adaptive.md
class Navigator {
 public:
  /// @param calibration  what the filter assumes; never the truth (but see oracle)
  /// @throws std::invalid_argument as StereoFilter
  Navigator(const NavigatorOptions& options, const StereoCalibration& calibration,
            const InitialState& initial);

  /// @throws std::invalid_argument as StereoFilter::add_imu
  void add_imu(const ImuSample& sample);
  /// As add_imu, in the place of an IMU.
  void add_odometry(const OdometrySample& sample);

  /// How much later than taken an IMU's samples are stamped by now, as far as the images showed it [ns]: they
  /// are used so. Where it is positive, feed them up to a frame's time and as much more.
  [[nodiscard]] std::int64_t clock_offset_ns() const;

  /// @brief Advances the state to the frame and corrects it.
  /// @throws std::invalid_argument as StereoFilter::process
  FrameReport process(const StereoFrame& frame);

  /// @brief A frame of before the state, which a start has used up: the verdict on the calibration begins
  /// with those. In the order of time, before the first process().
  /// @param nav       of the body when the frame was taken
  /// @param velocity  covariance of its velocity [m^2/s^2]; zero: nothing tells how long a metre is
  /// @return what is known of the calibration, as FrameReport::calibration
  std::shared_ptr<const CalibrationReport> watch_earlier(const StereoFrame& frame, const NavigationState& nav,
                                                         const Eigen::Matrix3d& velocity);

  /// @brief Begins anew, with the options and the calibration of the construction; time may begin anew, too.
  /// @throws std::invalid_argument if shapes disagree or the state is not finite; nothing has changed then
  void reset(const InitialState& initial);

  /// The body at t_ns with the inputs so far, for instance at the rate of the IMU; changes nothing. The state
  /// itself if t_ns is not later. Its covariance is as StereoFilter::predict has it.
  [[nodiscard]] PredictedState predict(std::int64_t t_ns) const { return answering().predict(t_ns); }

  /// The door of `oracle`, and of nobody else: the rig as it is from now on, which the filter takes for true.
  /// @throws as StereoFilter::show_true_rig
  void show_true_rig(const TrueRig& truth) { filter_.show_true_rig(truth); }

  /// Mean and covariance of body, parameters and map. Invalidated by the next call.
  [[nodiscard]] const Estimate& estimate() const { return answering().estimate(); }
  /// The calibration that the filter takes for true: what was given, with what has been estimated.
  [[nodiscard]] const StereoCalibration& calibration() const { return filter_.calibration(); }
  /// What has been learned of the calibration; zero where nothing is estimated.
  [[nodiscard]] CalibrationEstimate calibration_estimate() const { return filter_.calibration_estimate(); }
  /// As they were given at the construction.
  [[nodiscard]] const NavigatorOptions& options() const { return filter_.options(); }
  /// What is learned of the pixels; null unless it is asked for. Invalidated by the next call.
  [[nodiscard]] const LearnedPixelNoise* pixel_noise() const { return answering().pixel_noise(); }
  /// The same of an IMU.
  [[nodiscard]] const LearnedImuNoise* imu_noise() const { return answering().imu_noise(); }
  /// The same of a motion that nothing measures.
  [[nodiscard]] const LearnedImuNoise* learned_motion_noise() const {
    return answering().learned_motion_noise();
  }
  /// The same of odometry.
  [[nodiscard]] const LearnedOdometryNoise* odometry_noise() const { return answering().odometry_noise(); }
  /// Samples and frames that are kept to go back in time: some seconds of them, for `adaptive` alone.
  [[nodiscard]] std::size_t events_kept() const;
  /// What the alarm made of the last frame; nothing before it, or if the calibration is not watched.
  [[nodiscard]] const std::optional<HealthReport>& health() const { return health_; }
  /// @brief What is known of the calibration; null before the first window is over, or if it is not watched.
  ///
  /// Of all frames so far. FrameReport::calibration has the same a second or two after a window's end: no
  /// frame waits for it. What of it is not done yet is done here, and takes some milliseconds, once for each
  /// window: without more frames it is the same object.
  [[nodiscard]] std::shared_ptr<const CalibrationReport> calibration_report() const {
    return watch_ ? watch_->report_at_once() : nullptr;
  }

 private:
  using Event = std::variant<ImuSample, OdometrySample, StereoFrame>;
  struct Checkpoint {
    std::shared_ptr<const StereoFilter> filter;
    std::int64_t t_ns;
    std::vector<Event> events;  // since
  };
  /// Normalised innovations squared of the last second or so, as sums that fade.
  struct RecentFit {
    double nis = 0.0, dof = 0.0;
    void add(const FrameReport& report);
  };
  struct Supervision {
    StereoFilter parallel;  // constrained
    HealthMonitor own_alarm, parallel_alarm;
    Checkpoint older, recent;
    std::int64_t began_ns = 0;
    std::int64_t doubted_ns = 0;  // last
    int doubts = 0;               // in a row
    int overruled = 0;            // frames in a row in which the filter's own gate was, and not that beside
    bool trusts = true;
    bool resigned = false;     // nobody can know how long a metre is: what is assumed stays as good as any
    bool gave_up = false;      // but it fits nothing: the parallel filter answers for good
    bool unconfirmed = false;  // what the last frame says of the rig: the parallel filter answers meanwhile
    RecentFit own_fit{}, parallel_fit{};
    std::optional<std::deque<Event>> replay{};  // what filter_, come back from a checkpoint, has not seen yet
  };

  void log(const Event& event);
  void go_back(const CalibrationPrior& prior);
  void replay();
  void watch_anew(std::int64_t t_ns);
  void take_over_from_parallel(std::int64_t t_ns);
  /// It is neither on its way back in time nor left for good.
  [[nodiscard]] bool filter_keeps_up() const {
    return !supervision_ || (!supervision_->replay && !supervision_->gave_up);
  }
  /// The filter whose state counts.
  [[nodiscard]] const StereoFilter& answering() const {
    return filter_keeps_up() && !(supervision_ && supervision_->unconfirmed) ? filter_
                                                                             : supervision_->parallel;
  }
  [[nodiscard]] CalibrationPrior prior_after(const HealthReport& why) const;
  [[nodiscard]] bool knows_scale(std::int64_t t_ns) const;
  [[nodiscard]] bool contradicts_rig(const FrameReport& report, const FrameReport& parallel) const;
  void doubt(std::int64_t t_ns);
  bool replaces_reset(const FrameReport& parallel);
  bool supervise(const FrameReport& report, const FrameReport& parallel);
  [[nodiscard]] bool vergence_is_off() const;
  void compare_fits(const FrameReport& report, const FrameReport& parallel);

  [[nodiscard]] std::shared_ptr<const CalibrationReport> known_calibration() const;
  void watch(const StereoFrame& frame, const StereoFilter& filter, const FrameReport& report);

  double baseline_;  // of the assumed calibration [m]
  Pose T_body_cam0_;
  StereoFilter filter_;
  std::optional<HealthReport> health_;
  std::optional<CalibrationWatch> watch_;
  std::optional<Supervision> supervision_;  // adaptive
};

}  // namespace limber
