// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "limber/core/pose.hpp"
#include "limber/evaluate/alignment.hpp"
#include "limber/evaluate/association.hpp"

/// Does a filter know how wrong it is? [BarShalom2001], section 5.4.
namespace limber {

/// Pose error, position then attitude: p_true - p_est in the world [m]; dtheta with R_true = R_est
/// Exp(dtheta) [rad].
using PoseErrorVector = Eigen::Matrix<double, 6, 1>;
/// Covariance of a PoseErrorVector [m², m rad, rad²].
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// The error of an estimate, see PoseErrorVector.
[[nodiscard]] PoseErrorVector pose_error(const Pose& estimate, const Pose& truth);

/// Normalised estimation errors squared e' P^-1 e: chi-square with 6, 3 and 3 d.o.f. where the filter is
/// consistent.
struct PoseNees {
  /// 6 d.o.f.
  double pose = 0.0;
  /// 3 d.o.f.
  double position = 0.0;
  /// 3 d.o.f., of the local attitude error
  double attitude = 0.0;
};

/// @return nothing if P is not positive definite (or not finite)
[[nodiscard]] std::optional<PoseNees> pose_nees(const PoseErrorVector& error, const PoseCovariance& P);

/// @brief Normalised squared error of the distance from where the body began: what a wrong scale does to a
/// path, whatever its direction. Chi-square with 1 d.o.f. where the filter is consistent.
/// @param from_begin true displacement since the first position, in the world of the truth [m]
/// @return nothing where the body has not moved, or the variance is not positive and finite
[[nodiscard]] std::optional<double> distance_nees(const PoseErrorVector& error, const PoseCovariance& P,
                                                  const Eigen::Vector3d& from_begin);

/// The covariance of a pose error whose world is turned by R; the attitude error is local and stays.
[[nodiscard]] PoseCovariance turned(const PoseCovariance& P, const Eigen::Matrix3d& R);

/// Average NEES over a run.
struct Consistency {
  std::size_t frames = 0;  ///< that entered the averages
  std::size_t frames_refused =
      0;  ///< whose covariance is not positive definite: a filter that broke, unless 0
  std::optional<PoseNees>
      anees;  ///< NEES per d.o.f. (divided by 6, 3 and 3), mean over the frames; 1 = consistent
  std::optional<double>
      anees_scale;  ///< mean distance_nees over those of the frames that have one; 1 = consistent
  double share_within_95 =
      0.0;  ///< frames whose pose NEES is below the 95 % quantile of chi-square(6), 0 to 1
};

/// Frames up to this long [s] after the start of the estimate do not enter an average.
inline constexpr double kNeesSkip = 1.0;

/// @brief Averages the NEES of all frames later than `skip` [s] after `start_ns`.
/// @param[in] covariances of the estimate, one per estimated pose: MatchedPose::index counts in this list
/// @param[in] alignment   rigid; turns estimate and position covariance into the world of the truth first
/// @throws std::invalid_argument if an index has no covariance, the alignment is not kAligned or has a scale
[[nodiscard]] Consistency average_nees(std::span<const MatchedPose> poses,
                                       std::span<const PoseCovariance> covariances,
                                       const Alignment& alignment, std::int64_t start_ns,
                                       double skip = kNeesSkip);

/// A closed interval of real numbers.
struct Interval {
  /// part of the interval
  double lower = 0.0;
  /// part of the interval
  double upper = 0.0;
};

/// @brief Where the mean of `samples` *independent* chi-square(dof) variables, divided by dof, lies with
/// `probability` (two-sided, equal tails). Frames of one run correlate: use it over runs, or over
/// innovations.
/// @throws std::invalid_argument if samples is zero, dof <= 0, or probability is not in (0, 1)
[[nodiscard]] Interval normalized_mean_interval(double dof, std::size_t samples, double probability = 0.95);

/// One update's normalised innovation squared r' S^-1 r.
struct NisSample {
  /// chi-square with `dof`
  double nis = 0.0;
  double dof = 0.0;  ///< rows that entered
};

/// All updates of a run together: innovations of a consistent filter are white, so their sum is chi-square.
struct NisAverage {
  /// how many samples entered
  std::size_t updates = 0;
  double dof = 0.0;      ///< in total
  double per_dof = 0.0;  ///< 1 = consistent
  Interval interval;     ///< two-sided 95 % interval of per_dof
  double p_value =
      0.0;  ///< probability of a sum at least as large; small: errors larger than the filter thinks
};

/// @return nothing if the samples have no degree of freedom in total
/// @throws std::invalid_argument if a sample is negative or not finite
[[nodiscard]] std::optional<NisAverage> average_nis(std::span<const NisSample> samples);

}  // namespace limber
