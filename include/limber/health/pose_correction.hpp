// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace limber {

/// How a frame corrected the predicted pose.
struct PoseCorrection {
  /// position [m], attitude [rad]
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  /// covariance of a Vector6
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// [ns], of the frame
  std::int64_t t_ns = 0;
  double dt = 0.0;     ///< since the frame before [s]
  Vector6 dx;          ///< position [m], attitude [rad]
  Matrix6 covariance;  ///< of dx, if the prediction was right: P before minus P after the update
  double nis = 0.0;    ///< of all rows [-]
  double dof = 0.0;    ///< of nis
};

/// The correction in units of its standard deviations, each near its own axis; directions that the frame did
/// not see are zero.
[[nodiscard]] PoseCorrection::Vector6 whitened(const PoseCorrection& correction);

/// NIS per degree of freedom of what the pose does not explain: it tells the noise.
/// @param z  the correction, whitened
[[nodiscard]] double scatter_beside(const PoseCorrection& correction, const PoseCorrection::Vector6& z);
/// The same.
[[nodiscard]] double scatter_beside(const PoseCorrection& correction);

/// @brief How the last frames corrected the pose: the fading mean of some ten whitened corrections, beside
/// the noise that their other rows show. White noise of size one has a mean square of `expected_square()`.
class RecentCorrections {
 public:
  /// @return false, and nothing is added, where the correction tells nothing: it is not finite or has no rows
  bool add(const PoseCorrection& correction);

  /// Forgets the mean, not the noise.
  void restart_mean();

  /// Of the last frame, whitened.
  [[nodiscard]] const PoseCorrection::Vector6& last() const { return last_; }
  /// Fading.
  [[nodiscard]] const PoseCorrection::Vector6& mean() const { return mean_; }
  /// Of each number of the mean, were corrections white and of size one.
  [[nodiscard]] double expected_square() const { return weight_; }
  /// NIS / dof of other rows: smoothed or of the last frame, whichever is larger, and at least 1. What is
  /// assumed may be much more than frames show, since it stands for what lasts in a point's pixels, too: the
  /// points of a frame that shows more than three times what is usual contradict each other, and what they
  /// say of the pose is worth as much less.
  [[nodiscard]] double noise() const;
  /// The last frame's points, ten or more, contradict each other.
  [[nodiscard]] bool points_quarrel() const { return quarrel_ > 1.0; }
  /// noise(), of the worst of the frames in the mean.
  [[nodiscard]] double lasting_noise() const;
  /// The first ten correct what a start did not know, and say nothing of the inputs.
  [[nodiscard]] bool are_of_a_start() const { return frames_ <= 10; }

 private:
  PoseCorrection::Vector6 last_ = PoseCorrection::Vector6::Zero(), mean_ = PoseCorrection::Vector6::Zero();
  double weight_ = 0.0;           // sum of squared weights of mean_
  double smoothed_ = 1.0;         // NIS / dof of other rows
  double usual_ = 0.0;            // the same; of the first frames a plain mean
  double rest_ = 1.0;             // that of the last frame
  double quarrel_ = 0.0;          // rest_ over three times what was usual before it
  double lasting_quarrel_ = 0.0;  // the largest, fading as the mean does
  int frames_ = 0;
};

}  // namespace limber
