// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/core/covariance.hpp"
#include "limber/core/dense.hpp"

namespace limber {

/// @brief A matrix to which a large product is added in shares, so that no single call pays for it.
///
/// It is S + A B: S has been added up, the product waits. Every accessor gives the sum, and every change is
/// done to both, so that how much waits shows in no value but by rounding.
class SettlingMatrix {
 public:
  [[nodiscard]] Eigen::Index rows() const { return rows_; }           ///< number of rows
  [[nodiscard]] Eigen::Index cols() const { return stored_.cols(); }  ///< number of columns

  /// Full copy, rows × cols.
  [[nodiscard]] Eigen::MatrixXd dense() const;
  /// The three columns from `start` on, rows × 3.
  [[nodiscard]] Eigen::MatrixXd triplet(Eigen::Index start) const;
  /// The transpose times x, x of rows().
  [[nodiscard]] Eigen::VectorXd transposed_times(const Eigen::Ref<const Eigen::VectorXd>& x) const;

  /// Becomes S + A B, A: rows × l, B: l × cols; the product in `shares` calls of settle().
  /// @param S  at least rows × cols: what is below is room for append_rows()
  void assign_in_shares(Eigen::MatrixXd S, Eigen::MatrixXd A, Eigen::MatrixXd B, Eigen::Index shares);
  /// Adds one share of what waits.
  void settle();
  /// Adds all of it. @return the sum
  MatrixRef settle_all();

  /// The three rows from `row` on += C times the whole, C: 3 × rows.
  void add_to_rows(Eigen::Index row, const MatrixRef& C);
  /// The three rows from `row` on += M times the three rows from `from` on.
  void couple_rows(Eigen::Index row, Eigen::Index from, const Eigen::Matrix3d& M);
  /// The three rows from `row` on become M times themselves.
  void transform_rows(Eigen::Index row, const Eigen::Matrix3d& M);
  /// The rows above += alpha A B, A: k × l, B: l × cols.
  void add_product_above(double alpha, const MatrixRef& A, const MatrixRef& B);
  /// The 3×3 block at (row, col) += D.
  void add_block(Eigen::Index row, Eigen::Index col, const Eigen::Matrix3d& D);
  /// The three columns from `start` on become themselves times M.
  void transform_triplet(Eigen::Index start, const Eigen::Matrix3d& M);
  /// Appends rows, of cols() columns each.
  void append_rows(const MatrixRef& rows);
  /// Forgets the three columns from `start` on; the last three take their place.
  void remove_triplet(Eigen::Index start);

 private:
  void settle(Eigen::Index share);
  [[nodiscard]] auto waiting_left() const { return A_.leftCols(waiting_); }
  [[nodiscard]] auto waiting_right() const { return B_.topRows(waiting_); }

  [[nodiscard]] auto settled() const { return stored_.topRows(rows_); }
  [[nodiscard]] auto settled() { return stored_.topRows(rows_); }

  Eigen::MatrixXd stored_, A_, B_;  // stored_: with spare rows
  Eigen::Index rows_ = 0;
  Eigen::Index waiting_ = 0, share_ = 0;  // of the columns of A_, which are the rows of B_
};

}  // namespace limber
