// SPDX-License-Identifier: MIT
#include "limber/run/trusted_axes.hpp"

namespace limber {
namespace {

bool lcekf_trusts(const RunOptions& options, MotionModel motion, std::size_t axis) {
  const ConstraintSet set = options.constraints.value_or(ConstraintSet{
      has_scale(motion) ? ConstraintSet::Kind::kFull : ConstraintSet::Kind::kRotationDirection, {}});
  switch (set.kind) {
    case ConstraintSet::Kind::kFull:
    case ConstraintSet::Kind::kRotationDirection:
      return false;
    case ConstraintSet::Kind::kRotation:
      return axis >= 3;
    case ConstraintSet::Kind::kListed:
      break;
  }
  return !set.listed[axis];
}

}  // namespace

bool trusts_axis(const RunOptions& options, MotionModel motion, std::size_t axis) {
  const auto k = static_cast<Eigen::Index>(axis);
  if (options.estimated(k) != 0.0 || options.softened(k) != 0.0) {
    return false;
  }
  return options.method == Method::kEkf ||
         (options.method == Method::kLcekf && lcekf_trusts(options, motion, axis));
}

bool trusts_length_alone(const RunOptions& options) {
  return options.method == Method::kLcekf && options.constraints &&
         options.constraints->kind == ConstraintSet::Kind::kRotationDirection;
}

bool trusts_length(const RunOptions& options, MotionModel motion, const RigParameters& theta) {
  Eigen::Index along = 0;
  theta.tail<3>().cwiseAbs().maxCoeff(&along);
  return trusts_length_alone(options) || trusts_axis(options, motion, static_cast<std::size_t>(3 + along));
}

}  // namespace limber
