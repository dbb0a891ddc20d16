// SPDX-License-Identifier: MIT
#include "limber/core/settling_covariance.hpp"

#include <algorithm>
#include <utility>

#include "limber/core/dense.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd SettlingCovariance::dense() const {
  MatrixXd out = settled_.dense();
  if (waiting_.rows() > 0) {
    add_product(out, 1.0, transposed(waiting_), waiting_);
  }
  return out;
}

Eigen::Matrix3d SettlingCovariance::triplet_block(Index row, Index col) const {
  Eigen::Matrix3d out = settled_.triplet_block(row, col);
  if (waiting_.rows() > 0) {
    out += waiting_.middleCols<kTriplet>(row).transpose() * waiting_.middleCols<kTriplet>(col);
  }
  return out;
}

void SettlingCovariance::gather(std::span<const Index> starts, MatrixXd& columns) const {
  settled_.gather(starts, columns);
  if (waiting_.rows() == 0) {
    return;
  }
  MatrixXd picked(waiting_.rows(), columns.cols());
  for (std::size_t k = 0; k < starts.size(); ++k) {
    picked.middleCols<kTriplet>(kTriplet * static_cast<Index>(k)) = waiting_.middleCols<kTriplet>(starts[k]);
  }
  add_product(columns, 1.0, transposed(waiting_), picked);
}

void SettlingCovariance::add_in_shares(MatrixXd Wt, Index shares) {
  waiting_ = std::move(Wt);
  share_ = (waiting_.rows() + shares - 1) / shares;
}

void SettlingCovariance::settle() { settle(std::min(share_, waiting_.rows())); }

void SettlingCovariance::settle(Index rows) {
  if (rows > 0) {
    settled_.add_outer(waiting_.bottomRows(rows).transpose());
    waiting_ = waiting_.topRows(waiting_.rows() - rows).eval();
  }
}

void SettlingCovariance::transform_triplet(Index start, const Eigen::Matrix3d& M) {
  settled_.transform_triplet(start, M);
  if (waiting_.rows() > 0) {
    waiting_.middleCols<kTriplet>(start) = (waiting_.middleCols<kTriplet>(start) * M.transpose()).eval();
  }
}

Index SettlingCovariance::remove_triplet(Index start) {
  const Index last = settled_.remove_triplet(start);
  if (waiting_.rows() > 0) {
    if (start != last) {
      waiting_.middleCols<kTriplet>(start) = waiting_.rightCols<kTriplet>().eval();
    }
    waiting_.conservativeResize(Eigen::NoChange, last);
  }
  return last;
}

}  // namespace limber
