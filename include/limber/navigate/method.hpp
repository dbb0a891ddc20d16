// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/parameters.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// What a filter makes of the assumed rig theta.
enum class Method : std::uint8_t {
  kEkf,       ///< trusts it
  kEkfFull,   ///< estimates it as a random walk
  kLcekf,     ///< keeps its gain blind to the constrained directions
  kSoft,      ///< expects a fresh, finite error in every frame
  kConsider,  ///< carries its uncertainty, never corrects it (Schmidt)
  kAdaptive,  ///< trusts it until it is proven wrong, then learns how wrong it is
  kMonoLeft,  ///< does not look through the right camera
  kOracle     ///< trusts it, and is told the truth by the application (simulation only)
};

/// All methods, in the order of tables.
inline constexpr std::array kAllMethods = {Method::kEkf,      Method::kEkfFull,  Method::kLcekf,
                                           Method::kSoft,     Method::kConsider, Method::kAdaptive,
                                           Method::kMonoLeft, Method::kOracle};

/// Name on the command line: ekf, ekf-full, lcekf, soft, consider, adaptive, mono-left, oracle.
[[nodiscard]] std::string to_string(Method method);
/// @throws std::invalid_argument for another name; the message lists the known ones
[[nodiscard]] Method method_from_string(const std::string& name);

/// Parameters to which the gain is blind: directions of theta, and whatever else is listed.
struct ConstraintSet {
  /// Which directions are constrained.
  enum class Kind : std::uint8_t {
    kFull,               ///< all six
    kRotation,           ///< the three angles
    kRotationDirection,  ///< all but the length of the baseline
    kListed              ///< those in `listed`
  };
  /// which directions of theta
  Kind kind = Kind::kFull;
  ParameterSet listed{};  ///< of theta read for kListed only

  /// Whether any direction of theta is constrained.
  [[nodiscard]] bool has_theta() const {
    return kind != Kind::kListed || (listed & parameters_of(ParameterBlock::kTheta)).any();
  }
  /// Those listed beyond theta.
  [[nodiscard]] ParameterSet more() const { return listed & ~parameters_of(ParameterBlock::kTheta); }
  /// Whether nothing is constrained.
  [[nodiscard]] bool empty() const { return !has_theta() && listed.none(); }
};

/// What a constrained filter does not rely on unless it is told otherwise: `full` where the motion's inputs
/// show how long a metre is; `rotation+direction` of vision alone, whose scale nothing but the baseline's
/// length fixes.
[[nodiscard]] ConstraintSet default_constraints(MotionModel motion);

/// "full", "none", "rotation", "rotation+direction" or a list of names such as "ax,ay,tx"; names and groups
/// beyond theta may follow: "full,dt1,intrinsics1". Names: limber/sensors/parameters.hpp.
/// @throws std::invalid_argument for anything else
[[nodiscard]] ConstraintSet constraint_set_from_string(const std::string& text);
/// The word that constraint_set_from_string reads back.
[[nodiscard]] std::string to_string(const ConstraintSet& set);

/// A covariance of theta without its share along the baseline: the length is known for certain.
[[nodiscard]] Eigen::Matrix<double, 6, 6> without_length(const Eigen::Matrix<double, 6, 6>& covariance,
                                                         const RigParameters& theta);

/// C of theta: 6×k, columns scaled to one plausible error each. `rotation+direction` leaves the direction of
/// t_s out.
[[nodiscard]] Eigen::MatrixXd constraint_directions(const ConstraintSet& set, const RigParameters& theta);

}  // namespace limber
