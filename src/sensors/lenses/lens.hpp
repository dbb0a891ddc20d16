// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>

#include "limber/sensors/camera.hpp"

/// A lens model is one file beside this one: formulas and names, which camera.cpp and distortion.cpp pick by
/// the alternative that a camera holds. A further model is such a file, its struct in distortion.hpp and a
/// line in all_lenses.hpp.
namespace limber::detail {

template <typename Model>
struct Coefficient {
  std::string_view name;
  double Model::*value;
};

/// @brief Specialised for each model, with
/// kName and kCoefficients (an array of Coefficient, in the order of files),
/// project(Camera, Model, X), unproject(Model, m) of distorted normalised coordinates,
/// radial(Model, X): derivative of the distorted normalised coordinates with respect to k1.
template <typename Model>
struct Lens;

}  // namespace limber::detail
