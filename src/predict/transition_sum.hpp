// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/predict/motion.hpp"

namespace limber::detail {

/// Transitions that follow each other, as one. There is room for the body of every motion model, in whole
/// vectors of the processor: such products are faster than those of matrices of any size.
class TransitionSum {
 public:
  /// @param n  size of the body, 16 at most
  explicit TransitionSum(Eigen::Index n) : n_(n) {}

  void add(const Transition& step) {
    Padded F = Padded::Identity();
    F.topLeftCorner(n_, n_) = step.Phi;
    Phi_ = F.lazyProduct(Phi_).eval();
    Q_ = F.lazyProduct(F.lazyProduct(Q_).eval().transpose()).eval();
    Q_.topLeftCorner(n_, n_) += step.Q;
  }
  [[nodiscard]] Transition sum() const { return {Phi_.topLeftCorner(n_, n_), Q_.topLeftCorner(n_, n_)}; }

 private:
  using Padded = Eigen::Matrix<double, 16, 16>;

  Eigen::Index n_;
  Padded Phi_ = Padded::Identity(), Q_ = Padded::Zero();
};

}  // namespace limber::detail
