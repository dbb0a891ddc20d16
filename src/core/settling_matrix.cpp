// SPDX-License-Identifier: MIT
#include "limber/core/settling_matrix.hpp"

#include <algorithm>
#include <utility>

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd SettlingMatrix::dense() const {
  MatrixXd out = settled();
  if (waiting_ > 0) {
    add_product(out, 1.0, waiting_left(), waiting_right());
  }
  return out;
}

MatrixXd SettlingMatrix::triplet(Index start) const {
  MatrixXd out = settled().middleCols<kTriplet>(start);
  if (waiting_ > 0) {
    out.noalias() += waiting_left() * waiting_right().middleCols<kTriplet>(start);
  }
  return out;
}

VectorXd SettlingMatrix::transposed_times(const Eigen::Ref<const VectorXd>& x) const {
  VectorXd out = settled().transpose() * x;
  if (waiting_ > 0) {
    const VectorXd inner = waiting_left().transpose() * x;
    out.noalias() += waiting_right().transpose() * inner;
  }
  return out;
}

void SettlingMatrix::assign_in_shares(MatrixXd S, MatrixXd A, MatrixXd B, Index shares) {
  stored_ = std::move(S);
  rows_ = A.rows();
  A_ = std::move(A);
  B_ = std::move(B);
  waiting_ = A_.cols();
  share_ = (waiting_ + shares - 1) / shares;
}

void SettlingMatrix::settle() { settle(std::min(share_, waiting_)); }

MatrixRef SettlingMatrix::settle_all() {
  settle(waiting_);
  return settled();
}

void SettlingMatrix::settle(Index share) {
  if (share > 0) {
    waiting_ -= share;
    add_product(settled(), 1.0, A_.middleCols(waiting_, share), B_.middleRows(waiting_, share));
    if (waiting_ == 0) {  // or every copy of a map would carry them
      A_.resize(0, 0);
      B_.resize(0, 0);
    }
  }
}

void SettlingMatrix::add_to_rows(Index row, const MatrixRef& C) {
  stored_.middleRows<kTriplet>(row) += multiply(C, settled());
  if (waiting_ > 0) {
    A_.middleRows<kTriplet>(row) += multiply(C, A_);
  }
}

void SettlingMatrix::couple_rows(Index row, Index from, const Eigen::Matrix3d& M) {
  const auto couple = [&](MatrixXd& matrix) {
    matrix.middleRows<kTriplet>(row) += (M * matrix.middleRows<kTriplet>(from)).eval();
  };
  couple(stored_);
  if (waiting_ > 0) {
    couple(A_);
  }
}

void SettlingMatrix::transform_rows(Index row, const Eigen::Matrix3d& M) {
  const auto transform = [&](MatrixXd& matrix) {
    matrix.middleRows<kTriplet>(row) = (M * matrix.middleRows<kTriplet>(row)).eval();
  };
  transform(stored_);
  if (waiting_ > 0) {
    transform(A_);
  }
}

void SettlingMatrix::add_product_above(double alpha, const MatrixRef& A, const MatrixRef& B) {
  add_product(stored_.topRows(A.rows()), alpha, A, B);
}

void SettlingMatrix::add_block(Index row, Index col, const Eigen::Matrix3d& D) {
  stored_.block<kTriplet, kTriplet>(row, col) += D;
}

void SettlingMatrix::transform_triplet(Index start, const Eigen::Matrix3d& M) {
  settled().middleCols<kTriplet>(start) = (settled().middleCols<kTriplet>(start) * M).eval();
  if (waiting_ > 0) {
    B_.middleCols<kTriplet>(start) = (B_.middleCols<kTriplet>(start) * M).eval();
  }
}

void SettlingMatrix::append_rows(const MatrixRef& rows) {
  rows_ += rows.rows();
  if (stored_.rows() < rows_) {
    stored_.conservativeResize(rows_ + rows_ / 2, Eigen::NoChange);
  }
  settled().bottomRows(rows.rows()) = rows;
  if (waiting_ > 0) {
    A_.conservativeResize(rows_, Eigen::NoChange);
    A_.bottomRows(rows.rows()).setZero();
  }
}

void SettlingMatrix::remove_triplet(Index start) {
  const Index last = cols() - kTriplet;
  const auto forget = [&](MatrixXd& columns) {
    if (start != last) {
      columns.middleCols<kTriplet>(start) = columns.rightCols<kTriplet>().eval();
    }
    columns.conservativeResize(Eigen::NoChange, last);
  };
  forget(stored_);
  if (waiting_ > 0) {
    forget(B_);
  }
}

}  // namespace limber
