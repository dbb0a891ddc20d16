// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

namespace limber {

/// Two 3-vectors that drive the prediction at one time: (omega, accel) of an IMU, (v, omega) of odometry.
struct InputSample {
  std::int64_t t_ns = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
};

/// One step of the prediction: means of the inputs over (t_begin, t_end].
struct InputStep {
  std::int64_t t_end_ns = 0;
  double dt = 0.0;  ///< [s]
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  /// How much longer than usual the samples on both sides stand apart, >= 1: what happened in a gap is
  /// guessed, and its noise grows by this factor (in variance).
  double gap = 1.0;
};

/// @brief Holds input samples and cuts them into steps that end where the caller wants.
/// Between samples inputs are interpolated linearly; before the first and after the last they are held.
class InputBuffer {
 public:
  /// @throws std::invalid_argument if the time does not increase or a value is not finite
  void add(const InputSample& sample);

  /// Steps from `begin_ns` to `end_ns`, one for each sample in between; forgets samples older than needed.
  /// Empty if there is no sample at all or end <= begin.
  [[nodiscard]] std::vector<InputStep> steps(std::int64_t begin_ns, std::int64_t end_ns);

  [[nodiscard]] bool empty() const { return samples_.empty(); }

  /// Usual time between samples [s]; 0 before the second sample.
  [[nodiscard]] double usual_interval_s() const { return 1e-9 * usual_interval_ns_; }

 private:
  [[nodiscard]] InputSample at(std::int64_t t_ns, std::size_t next) const;
  [[nodiscard]] double gap_around(std::size_t next, std::int64_t end_ns) const;

  std::deque<InputSample> samples_;
  double usual_interval_ns_ = 0.0;
};

}  // namespace limber
