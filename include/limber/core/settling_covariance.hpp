// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>

#include "limber/core/covariance.hpp"

namespace limber {

/// @brief A Covariance to which large changes are added in shares, so that no single call pays for one.
///
/// It is S + Gᵀ Rᵀ R G: S has been added up, the product waits. Every accessor gives the sum, and every
/// change of the state (a triplet that leaves, is transformed, ...) is done to both, so that how much waits
/// shows in no value but by rounding.
class SettlingCovariance {
 public:
  /// Rows and columns, n.
  [[nodiscard]] Eigen::Index size() const { return settled_.size(); }

  /// Full symmetric copy, n×n.
  [[nodiscard]] Eigen::MatrixXd dense() const;
  /// The 3×3 block of two triplets.
  [[nodiscard]] Eigen::Matrix3d triplet_block(Eigen::Index row, Eigen::Index col) const;
  /// As Covariance::gather.
  void gather(std::span<const Eigen::Index> starts, Eigen::MatrixXd& columns) const;

  /// P += Gᵀ Rᵀ R G, R: k×m, G: m×n; in `shares` calls of settle(). What waited before is
  /// added at once.
  void add_in_shares(Eigen::MatrixXd R, Eigen::MatrixXd G, Eigen::Index shares);
  /// Adds one share of what waits.
  void settle();
  /// Adds all of it.
  void settle_all() { settle(R_.rows()); }

  /// As Covariance::subtract_outer.
  void subtract_outer(const Eigen::Ref<const Eigen::MatrixXd>& W) { settled_.subtract_outer(W); }
  /// As Covariance::transform_triplet.
  void transform_triplet(Eigen::Index start, const Eigen::Matrix3d& M);
  /// As Covariance::append: zero rows and columns. What waited is added at once.
  Eigen::Index append(Eigen::Index count);
  /// As Covariance::remove_triplet.
  Eigen::Index remove_triplet(Eigen::Index start);

 private:
  void settle(Eigen::Index rows);
  [[nodiscard]] bool waits() const { return R_.rows() > 0; }

  Covariance settled_;
  Eigen::MatrixXd R_, G_;   // what waits; G_ follows every change of the state
  Eigen::Index share_ = 0;  // rows of R_
};

}  // namespace limber
