// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "limber/navigate/method.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// Random walk of theta that ekf-full assumes, in place of the scenario's.
struct ThetaWalk {
  double factor = 1.0;  ///< multiples of the scenario's variances; read unless `absolute`
  /// true: rotation and translation are read
  bool absolute = false;
  double rotation = 0.0;     ///< variance per 10 ms [rad^2], as theta_walk_rotation of a scenario
  double translation = 0.0;  ///< variance per 10 ms [mm^2], as theta_walk_translation of a scenario
};

/// A method with what a study may vary of it.
struct MethodVariant {
  /// what the filter makes of theta
  Method method = Method::kLcekf;
  std::optional<ConstraintSet> constraints;  ///< lcekf; nothing: the default for the scenario's sensors
  /// how points stand in the state
  LandmarkKind landmarks = LandmarkKind::kInverseDepth;
  std::optional<ThetaWalk> walk;  ///< ekf-full
  /// As --estimate, --soften and --assume-error of `limber run`; empty: none.
  std::string estimate, soften, assume;
};

/// @brief "METHOD[:OPTION...]": METHOD as on the command line; an option is a constraint set (lcekf),
/// `cartesian`, a walk of theta (ekf-full): `walk=x10` (multiplies its variances) or `walk=1e-6/1`
/// (variances per 10 ms, rad^2 and mm^2), or `estimate=`, `soften=`, `assume=` with what `limber run` takes
/// behind --estimate, --soften and --assume-error (named parameters only). For instance
/// "lcekf:rotation+direction", "lcekf:cartesian", "ekf-full:walk=0/0", "ekf:estimate=dt1:assume=dt1=0.005".
/// @throws std::invalid_argument for anything else; the message says what was expected
[[nodiscard]] MethodVariant method_variant_from_string(std::string_view text);

/// The shortest text that method_variant_from_string reads back: the label of tables and curves.
[[nodiscard]] std::string to_string(const MethodVariant& variant);

/// @brief Comma-separated variants. A parameter's name after a comma, with or without a value, belongs to the
/// list before it, so that "lcekf:ax,tx,ekf" are two.
/// @throws std::invalid_argument if one is broken, comes twice, or there is none
[[nodiscard]] std::vector<MethodVariant> method_variants_from_string(std::string_view text);

}  // namespace limber
