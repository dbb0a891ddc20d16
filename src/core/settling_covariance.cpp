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
  if (waits()) {
    const MatrixXd Wt = multiply(R_, G_);
    add_product(out, 1.0, transposed(Wt), Wt);
  }
  return out;
}

Eigen::Matrix3d SettlingCovariance::triplet_block(Index row, Index col) const {
  Eigen::Matrix3d out = settled_.triplet_block(row, col);
  if (waits()) {
    out += (R_ * G_.middleCols<kTriplet>(row)).transpose() * (R_ * G_.middleCols<kTriplet>(col));
  }
  return out;
}

void SettlingCovariance::gather(std::span<const Index> starts, MatrixXd& columns) const {
  settled_.gather(starts, columns);
  if (!waits()) {
    return;
  }
  MatrixXd picked(G_.rows(), columns.cols());
  for (std::size_t k = 0; k < starts.size(); ++k) {
    picked.middleCols<kTriplet>(kTriplet * static_cast<Index>(k)) = G_.middleCols<kTriplet>(starts[k]);
  }
  const MatrixXd RtR_picked = multiply(transposed(R_), multiply(R_, picked));
  add_product(columns, 1.0, transposed(G_), RtR_picked);
}

void SettlingCovariance::add_in_shares(MatrixXd R, MatrixXd G, Index shares) {
  settle_all();
  R_ = std::move(R);
  G_ = std::move(G);
  share_ = (R_.rows() + shares - 1) / shares;
}

void SettlingCovariance::settle() { settle(std::min(share_, R_.rows())); }

void SettlingCovariance::settle(Index rows) {
  if (rows > 0) {
    settled_.add_outer(multiply(R_.bottomRows(rows), G_).transpose());
    R_ = R_.topRows(R_.rows() - rows).eval();
    if (!waits()) {
      G_.resize(0, 0);  // or every copy of a map would carry it
    }
  }
}

Index SettlingCovariance::append(Index count) {
  settle_all();
  return settled_.append(count);
}

void SettlingCovariance::transform_triplet(Index start, const Eigen::Matrix3d& M) {
  settled_.transform_triplet(start, M);
  if (waits()) {
    G_.middleCols<kTriplet>(start) = (G_.middleCols<kTriplet>(start) * M.transpose()).eval();
  }
}

Index SettlingCovariance::remove_triplet(Index start) {
  const Index last = settled_.remove_triplet(start);
  if (waits()) {
    if (start != last) {
      G_.middleCols<kTriplet>(start) = G_.rightCols<kTriplet>().eval();
    }
    G_.conservativeResize(Eigen::NoChange, last);
  }
  return last;
}

}  // namespace limber
