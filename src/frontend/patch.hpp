// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "limber/frontend/grey_image.hpp"

namespace limber::frontend {

/// Where a patch was found: its point x [px from its centre] is at uv + A x.
struct PatchFit {
  Eigen::Vector2d uv;
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  double ncc = 0.0;   ///< normalised cross-correlation there, in [-1, 1]
  double rest = 0.0;  ///< what the patch does not explain there, root mean square [grey levels]
};

/// What may happen to a patch from one image to the other.
enum class PatchMotion { kShift, kAffine };

/// @brief A square of grey values around a sub-pixel point, to be found again in another image.
/// The alignment is blind to gain and offset of the brightness: exposures of two cameras differ. Inverse
/// compositional [Baker2004], with gain and offset projected out of the steepest-descent images.
/// @tparam Columns  6: shifts and shapes can be found; 2: shifts alone, for a third of the work
template <int Columns>
class BasicPatch {
 public:
  static constexpr int kRadius = 7;  ///< [px]; the square is 2 kRadius + 1 wide

  /// @return nothing if the square leaves the image, or has too little texture to fix two coordinates.
  [[nodiscard]] static std::optional<BasicPatch> cut(const GreyImage& image, const Eigen::Vector2d& uv);

  /// @brief Sub-pixel place of the patch near `start`, whose A is kept unless the motion is affine.
  /// @param motion  kAffine for six columns only
  /// @return nothing if it runs away by more than `max_shift_px`, is torn out of shape, leaves the image, or
  ///         does not settle.
  [[nodiscard]] std::optional<PatchFit> find(const GreyImage& image, const PatchFit& start,
                                             PatchMotion motion, double max_shift_px) const;

 private:
  static constexpr int kWidth = 2 * kRadius + 1;
  static constexpr int kArea = kWidth * kWidth;
  /// Values of the points, row by row. Rows end in a zero: vector instructions take them whole.
  using Values = Eigen::Array<float, kWidth + 1, kWidth>;

  /// Sums over the square of what is seen there.
  template <int Steps>
  struct Sums {
    float contrast_squared = 0.0f;  ///< of the values without their mean
    float gain = 0.0f;              ///< with value_
    Eigen::Matrix<float, Steps, 1> descent;
  };
  template <int Steps>
  [[nodiscard]] Sums<Steps> sums(const Values& seen) const;

  static Values unit_grid(bool along_u);
  static void remove_mean(Values& values);
  static bool sample_upright(const GreyImage& image, const Eigen::Vector2d& uv, Values& values);
  static bool sample(const GreyImage& image, const Eigen::Vector2d& uv, const Eigen::Matrix2d& A,
                     Values& values);

  Values value_;  ///< grey values without their mean, scaled to unit length
  /// Derivative of value_: shift u, v; A - I by columns, at the edge of the square; orthogonal to value_ and
  /// to 1.
  std::array<Values, Columns> descent_;
  Eigen::Matrix2f H_shift_inverse_;  ///< inverse Gauss-Newton matrices
  Eigen::Matrix<float, Columns, Columns> H_inverse_;
};

using Patch = BasicPatch<6>;
using ShiftPatch = BasicPatch<2>;

}  // namespace limber::frontend
