// SPDX-License-Identifier: MIT
#include "limber/run/trusted_axes.hpp"

namespace limber {
namespace {

ConstraintSet constraints_of(const RunOptions& options, MotionModel motion) {
  return options.constraints.value_or(default_constraints(motion));
}

bool lcekf_trusts(const RunOptions& options, MotionModel motion, std::size_t axis) {
  const ConstraintSet set = constraints_of(options, motion);
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

bool trusts_length_alone(const RunOptions& options, MotionModel motion) {
  return (options.method == Method::kLcekf &&
          constraints_of(options, motion).kind == ConstraintSet::Kind::kRotationDirection) ||
         (options.method == Method::kAdaptive && !has_scale(motion));
}

bool trusts_length(const RunOptions& options, MotionModel motion, const RigParameters& theta) {
  Eigen::Index along = 0;
  theta.tail<3>().cwiseAbs().maxCoeff(&along);
  return trusts_length_alone(options, motion) ||
         trusts_axis(options, motion, static_cast<std::size_t>(3 + along));
}

}  // namespace limber
