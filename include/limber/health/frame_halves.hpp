// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "limber/health/normal_equations.hpp"

namespace limber {

/// @brief Some frames that follow each other, each of which says twice what its rig's error is: by each half
/// of its tracks.
///
/// The halves share no track, and the errors of tracks are independent: so the mean of the products of both
/// is how much the rig itself varies, without a word about the noise of pixels.
struct FrameHalves {
  /// how many were added
  double frames = 0.0;
  NormalEquations::Vector first = NormalEquations::Vector::Zero();     ///< sum of beta of the first halves
  NormalEquations::Vector second = NormalEquations::Vector::Zero();    ///< of the second ones
  NormalEquations::Matrix products = NormalEquations::Matrix::Zero();  ///< sum of first secondᵀ

  /// One frame more: beta by the first and by the second half of its tracks.
  void add(const NormalEquations::Vector& of_first, const NormalEquations::Vector& of_second);
  /// The frames of both.
  FrameHalves& operator+=(const FrameHalves& other);
};

}  // namespace limber
