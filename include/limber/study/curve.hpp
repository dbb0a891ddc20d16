// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace limber {

/// What is averaged over runs at every stereo frame. Squared errors are sums over the axes of a vector,
/// variances the trace of its block of P: what "3 sigma" of a mean squared error is drawn from is 9 times the
/// mean variance.
enum class CurveQuantity : std::uint8_t {
  kPositionSquaredError,  ///< [m^2]
  kPositionVariance,      ///< [m^2]
  kAttitudeSquaredError,  ///< [rad^2]
  kAttitudeVariance,      ///< [rad^2]
  kLandmarkSquaredError,  ///< [m^2], mean over the points that are in the map and ahead of their anchor
  kLandmarks,             ///< [-], points that enter kLandmarkSquaredError
  kPoseNees,              ///< [-], 6 d.o.f.: 6 where the filter is consistent
  kPositionNees,          ///< [-], 3 d.o.f.
  kAttitudeNees,          ///< [-], 3 d.o.f.
  // What the filter takes for theta, per axis, methods with theta in the state (ekf-full, consider) only:
  // estimate minus what the filter started from (so that it compares with delta(t)), the square of the
  // estimate's error, and its variance. [rad], [m] and squares.
  kDeltaAx,
  kDeltaAy,
  kDeltaAz,
  kDeltaTx,
  kDeltaTy,
  kDeltaTz,
  kThetaSquaredErrorAx,
  kThetaSquaredErrorAy,
  kThetaSquaredErrorAz,
  kThetaSquaredErrorTx,
  kThetaSquaredErrorTy,
  kThetaSquaredErrorTz,
  kThetaVarianceAx,
  kThetaVarianceAy,
  kThetaVarianceAz,
  kThetaVarianceTx,
  kThetaVarianceTy,
  kThetaVarianceTz,
};

inline constexpr std::size_t kCurveQuantities = 27;  ///< kinds of quantities

/// The quantity of axis 0 to 5 (ax, ay, az, tx, ty, tz), counted from that of ax.
[[nodiscard]] constexpr CurveQuantity theta_axis(CurveQuantity of_ax, std::size_t axis) {
  return static_cast<CurveQuantity>(static_cast<std::size_t>(of_ax) + axis);
}

/// "position_squared_error", ...: name of exports. And its unit: "m^2", "rad^2", "-", ...
[[nodiscard]] std::string_view name_of(CurveQuantity quantity);
/// Its unit as text, empty for a pure number.
[[nodiscard]] std::string_view unit_of(CurveQuantity quantity);
/// @throws std::invalid_argument for a name that no quantity has
[[nodiscard]] CurveQuantity quantity_from_name(std::string_view name);

/// Mean over runs at every stereo frame. A run enters up to the frame before it diverged.
struct StudyCurve {
  std::vector<double> mean;          ///< NaN where no run enters
  std::vector<std::uint64_t> count;  ///< runs that enter
};

}  // namespace limber
