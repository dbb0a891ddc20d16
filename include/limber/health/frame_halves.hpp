// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/health/normal_equations.hpp"

namespace limber {

/// @brief Some frames that follow each other, each of which says twice what its rig's error is: by each half
/// of its tracks.
///
/// The halves share no track, and the errors of tracks are independent: so the mean of the products of both
/// is how much the rig itself varies, without a word about the noise of pixels.
///
/// What an error is worth in pixels is asked of each frame's own points: what is not known of ty at 8 m is no
/// movement of the pixels at 0.3 m.
struct FrameHalves {
  /// how many were added
  double frames = 0.0;
  NormalEquations::Vector first = NormalEquations::Vector::Zero();     ///< sum of beta of the first halves
  NormalEquations::Vector second = NormalEquations::Vector::Zero();    ///< of the second ones
  NormalEquations::Matrix products = NormalEquations::Matrix::Zero();  ///< sum of first secondᵀ
  NormalEquations::Matrix px = NormalEquations::Matrix::Zero();        ///< sum of what betas are worth [px^2]
  NormalEquations::Vector px_first = NormalEquations::Vector::Zero();  ///< sum of px times the first beta
  NormalEquations::Vector px_second = NormalEquations::Vector::Zero();  ///< and times the second one
  double px_products = 0.0;                                             ///< sum of firstᵀ px second

  /// One frame more: beta by the first and by the second half of its tracks.
  /// @param of_points  mean of J Jᵀ over its points, J the px that one leaves its epipolar line by
  void add(const NormalEquations::Matrix& of_points, const NormalEquations::Vector& of_first,
           const NormalEquations::Vector& of_second);
  /// The frames of both.
  FrameHalves& operator+=(const FrameHalves& other);
};

/// @brief The same of depths, about the mean of each stretch: by how much frames differ in the disparities
/// that they show, as if the cameras turned against each other, and as if the baseline's length changed.
///
/// Errors of the trajectory, and of depths from motion, are common to both halves. They go slowly, so that
/// what is left about the mean of half a second is the rig's.
struct DepthHalves {
  /// of what may have moved: the cameras' angle, the baseline's length (`depth_ways`)
  using Pair = Eigen::Array2d;

  double degrees = 0.0;          ///< of freedom: frames, less one for each stretch
  Pair products = Pair::Zero();  ///< sum over frames of first times second, each less its mean
  Pair px_squared =
      Pair::Zero();     ///< sum over points of what one plausible error moves them by, squared [px^2]
  double points = 0.0;  ///< that `px_squared` is the sum of

  /// One stretch.
  /// @param first, second  what the halves of each frame say [plausible errors]; alike in number
  void add_stretch(const std::vector<Pair>& first, const std::vector<Pair>& second);
  /// The stretches of both.
  DepthHalves& operator+=(const DepthHalves& other);
};

}  // namespace limber
