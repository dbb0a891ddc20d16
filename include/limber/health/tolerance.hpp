// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "limber/health/robust_estimate.hpp"

/// @file
/// Verdicts by equivalence: an interval against a band, not a test against zero.
namespace limber {

/// What can be said of a calibration, or of one of its axes.
enum class HealthVerdict : std::uint8_t {
  kOk,            ///< the interval lies inside the tolerance; of an alarm: what is seen agrees
  kSuspect,       ///< of an alarm alone: it hardly agrees
  kDegraded,      ///< it lies beyond what is ok, but not beyond what can be used
  kDecalibrated,  ///< it lies outside; of an alarm: it does not agree
  kCannotTell     ///< it is too wide, or there is none
};

/// "ok", "suspect", "degraded", "decalibrated", "cannot tell".
[[nodiscard]] std::string to_string(HealthVerdict verdict);

/// Degraded or decalibrated.
[[nodiscard]] bool is_wrong(HealthVerdict verdict);

/// How wrong a calibration may be: up to `ok`, and from `wrong` on it is not to be used.
struct Band {
  /// in the unit of what is judged; ok <= wrong
  double ok = 0.0, wrong = 0.0;
};

/// By effect, in two places: how far points lie from their epipolar lines (root mean square over the points
/// seen), and by how much a depth straight ahead is wrong.
struct Tolerance {
  /// root mean square of the distances [px]
  Band epipolar_px{0.3, 1.0};
  Band depth{0.05, 0.10};   ///< share of the depth
  double baselines = 90.0;  ///< the depth where `depth` holds
  /// Of an axis alone, in place of its effects [rad, m].
  std::array<std::optional<Band>, 6> axes{};

  /// @throws std::invalid_argument unless 0 < ok <= wrong everywhere
  void check() const;
};

/// A size, never negative, and the interval that holds it with 95 %.
struct SizeInterval {
  /// in the unit of what is judged
  double size = 0.0, low = 0.0, high = 0.0;
};

/// ok: high <= band.ok; decalibrated: low > band.wrong; degraded: low > band.ok; else cannot tell.
[[nodiscard]] HealthVerdict judge(const SizeInterval& interval, const Band& band);

/// What a rig's error does.
struct CalibrationEffect {
  /// root mean square over the points seen [px]
  SizeInterval epipolar_px;
  SizeInterval depth;         ///< share of the depth at `Tolerance::baselines`, to first order
  double depth_signed = 0.0;  ///< measured minus true
};

/// d(share of depth)/d(delta), straight ahead at that many baselines, to first order.
[[nodiscard]] RigParameters depth_slope(const RigParameters& theta, double baselines);

/// @brief The same at the tolerance's baselines, as far as it can be seen: without a sensor that knows a
/// metre the length of the baseline is trusted.
[[nodiscard]] RigParameters visible_slope(const RigParameters& theta, bool metric,
                                          const Tolerance& tolerance);

/// The square root of xᵀ M x with its interval, without what the errors of x add to it.
[[nodiscard]] SizeInterval root_of_form(const Eigen::VectorXd& x, const Eigen::MatrixXd& covariance,
                                        const Eigen::MatrixXd& M);

/// What the estimated error does to points and depths, each with its 95 % interval.
[[nodiscard]] CalibrationEffect effect_of(const BetaEstimate& estimate, const RigParameters& theta,
                                          const RigParameters& depth_slope);

/// An axis' own band: where its effect alone reaches the tolerance [rad, m]. Infinite where it has none that
/// is seen: of a length of the baseline that is trusted.
/// @param px  root mean square of the distance to the epipolar line, by axis [px by rad, m]
[[nodiscard]] std::array<Band, 6> axis_bands(const Tolerance& tolerance, const RigParameters& px,
                                             const RigParameters& depth_slope);

/// |delta| of one axis with its interval.
[[nodiscard]] SizeInterval axis_size(const RigEstimate& estimate, Eigen::Index axis);

/// @brief Which axis alone explains the offset best: the largest (V⁻¹ delta)_k² / (V⁻¹)_kk, of those whose
/// size would then be beyond what is ok (of all, if there is none such). A small error that is known well
/// does not hide a large one that is known less.
[[nodiscard]] Eigen::Index most_likely_axis(const RigEstimate& estimate, const std::array<Band, 6>& bands);

/// The worst of several: decalibrated, degraded, cannot tell, ok.
[[nodiscard]] HealthVerdict worst(HealthVerdict a, HealthVerdict b);

}  // namespace limber
