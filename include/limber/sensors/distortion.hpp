// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <variant>
#include <vector>

/// Lens models: how (x', y') of a camera, u = fu x' + cu and v = fv y' + cv, follow from the ray. All have
/// slope 1 on the axis, so that fu and fv are pixels per radian there. A model's formulas and names are in
/// one file of src/sensors/lenses.
namespace limber {

/// Distortion of normalised coordinates: none.
struct NoDistortion {
  /// member by member
  bool operator==(const NoDistortion&) const = default;
};

/// Radial-tangential ("plumb bob"): k1, k2, p1, p2 as in EuRoC and OpenCV.
struct RadialTangential {
  /// [-]
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;
  /// member by member
  bool operator==(const RadialTangential&) const = default;
};

/// Equidistant ("fisheye", Kannala-Brandt): theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8).
struct Equidistant {
  /// [-]
  double k1 = 0.0, k2 = 0.0, k3 = 0.0, k4 = 0.0;
  /// member by member
  bool operator==(const Equidistant&) const = default;
};

/// Radial-tangential with OpenCV's five (k3; KITTI's D) or eight coefficients (its rational model): radially
/// r (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6).
struct Rational {
  /// [-]
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0, k4 = 0.0, k5 = 0.0, k6 = 0.0;
  /// member by member
  bool operator==(const Rational&) const = default;
};

/// Unified (Mei's; Kalibr's omni): radial-tangential distortion of (x, y) / (z + xi |X|), times 1 + xi. So
/// the focal lengths of Mei, Kalibr and OpenCV's omnidir are 1 + xi times fu, fv. Needs xi > -1.
struct Omni {
  /// [-]
  double xi = 0.0, k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;
  /// member by member
  bool operator==(const Omni&) const = default;
};

/// How a lens departs from a pinhole.
using Distortion = std::variant<NoDistortion, RadialTangential, Equidistant, Rational, Omni>;

/// One of each model, in the order of the variant, coefficients zero.
[[nodiscard]] const std::vector<Distortion>& distortion_models();

/// What limber's files call a model: none, radial-tangential, equidistant, rational-polynomial, omni.
[[nodiscard]] std::string_view model_name(const Distortion& distortion);

/// Names of a model's coefficients in the order of files: k1, k2, ...
[[nodiscard]] std::vector<std::string_view> coefficient_names(const Distortion& distortion);

/// Its coefficients, in the same order [-].
[[nodiscard]] std::vector<double> coefficients(const Distortion& distortion);

/// @brief The same model with other coefficients, in the same order.
/// @throws std::invalid_argument if the model has another number of them
[[nodiscard]] Distortion with_coefficients(const Distortion& model, std::span<const double> values);

}  // namespace limber
