// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "limber/predict/motion_seen.hpp"

namespace limber {

/// What drives the prediction at one time, in the body frame.
struct InputSample {
  /// [ns]
  std::int64_t t_ns = 0;
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< rate [rad/s]
  Eigen::Vector3d linear =
      Eigen::Vector3d::Zero();  ///< IMU: specific force [m/s^2]; odometry: velocity [m/s]
  /// Variance density of what the values may be off by beyond their noise, per axis [unit^2 s]: a saturated
  /// sensor, a jump (InputChecks). Zero: nothing.
  double angular_density = 0.0, linear_density = 0.0;
};

/// @param newest_ns  of the samples before; nothing before the first
/// @throws std::invalid_argument if the sample is not later, or a value is not finite
void require_next(const InputSample& sample, std::optional<std::int64_t> newest_ns);

/// What is not known of one of the two inputs in a step.
struct Unknown {
  double memory = 1.0;   ///< correlation with the nearest samples: 0, they tell nothing of the step any more
  double density = 0.0;  ///< variance density of what the input may have been else, per axis [unit^2 s]
};

/// One step of the prediction: means of the inputs over (t_begin, t_end].
struct InputStep {
  /// [ns]
  std::int64_t t_end_ns = 0;
  double dt = 0.0;  ///< [s]
  /// mean rate [rad/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();
  /// mean specific force [m/s^2] or velocity [m/s]
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();
  /// How much longer than usual the samples on both sides stand apart, >= 1: the noise of what is
  /// interpolated grows by this factor (in variance).
  double gap = 1.0;
  Unknown angular_unknown{}, linear_unknown{};  ///< of a step in a gap
  /// How fast the inputs change in it, smoothed over the last tens of milliseconds [unit/s].
  Eigen::Vector3d angular_slope = Eigen::Vector3d::Zero(), linear_slope = Eigen::Vector3d::Zero();
};

/// What was seen of an input before any sample, per axis.
struct MotionPrior {
  double spread;        ///< standard deviation [unit]
  double rate;          ///< of change [unit/s]
  bool about_the_mean;  ///< the mean lasts (gravity in a specific force): it spreads about that, not about
                        ///< zero
};
/// Of both inputs.
struct InputPrior {
  /// [rad/s], and [m/s^2] of an IMU or [m/s] of odometry
  MotionPrior angular, linear;
};
/// Of a hand-held IMU.
inline constexpr InputPrior kImuPrior = {{0.5, 2.0, false}, {3.0, 20.0, true}};
/// Of a vehicle's odometry.
inline constexpr InputPrior kOdometryPrior = {{0.5, 2.0, true}, {2.0, 2.0, false}};

/// @brief Holds input samples and cuts them into steps that end where the caller wants.
///
/// Between samples inputs are interpolated linearly; before the first and after the last they are held. In a
/// gap (more than 1.5 usual intervals) each step also says how much the input may have changed since the
/// nearest sample, bounded by the motion seen (MotionSeen): see docs/derivations/faults.md.
class InputBuffer {
 public:
  /// @param prior  what such an input does before any sample has shown it
  explicit InputBuffer(const InputPrior& prior = kImuPrior)
      : prior_(prior),
        angular_seen_(prior.angular.spread, prior.angular.rate),
        linear_seen_(prior.linear.spread, prior.linear.rate) {}

  /// @throws std::invalid_argument if the time does not increase or a value is not finite
  void add(const InputSample& sample);

  /// @brief Steps from `begin_ns` to `end_ns`: one for each sample in between, and short ones in gaps.
  /// Without any sample all of it is a gap. Empty if end <= begin.
  [[nodiscard]] std::vector<InputStep> steps(std::int64_t begin_ns, std::int64_t end_ns) const;

  /// Forgets the samples that no step from `begin_ns` on needs.
  void forget_before(std::int64_t begin_ns);

  /// All samples, and those that are to come, were taken that much later [ns].
  void shift(std::int64_t by_ns);

  /// There is no sample.
  [[nodiscard]] bool empty() const { return samples_.empty(); }
  /// Samples that are held.
  [[nodiscard]] std::size_t size() const { return samples_.size(); }

  /// Time of the newest sample; only if there is one.
  [[nodiscard]] std::int64_t last_ns() const { return samples_.back().t_ns; }

  /// Usual time between samples [s]; 0 before the second sample.
  [[nodiscard]] double usual_interval_s() const { return 1e-9 * usual_interval_ns_; }

  /// Longest gap that reaches into (begin, end], from sample to sample or as far as it is known [s]; 0: none.
  [[nodiscard]] double longest_gap_s(std::int64_t begin_ns, std::int64_t end_ns) const;

 private:
  struct Smooth {
    Eigen::Vector3d angular, linear;
  };
  [[nodiscard]] std::size_t first_after(std::int64_t t_ns) const;
  [[nodiscard]] Smooth smooth_at(std::int64_t t_ns, std::size_t next) const;
  [[nodiscard]] InputSample at(std::int64_t t_ns, std::size_t next) const;
  [[nodiscard]] double gap_around(std::size_t next, std::int64_t begin_ns, std::int64_t end_ns) const;
  void doubt(InputStep& step, std::size_t next, std::int64_t begin_ns) const;

  std::deque<InputSample> samples_;
  std::deque<Smooth> smooth_;  // of each sample
  double usual_interval_ns_ = 0.0;
  InputPrior prior_;
  MotionSeen angular_seen_, linear_seen_;
};

}  // namespace limber
