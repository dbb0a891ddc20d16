// SPDX-License-Identifier: MIT
#include "limber/core/covariance.hpp"

#include <algorithm>
#include <array>

#include "limber/core/dense.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// The lower triangle of the leading n×n block.
void copy_lower(const MatrixXd& from, Index n, MatrixXd& to) {
  for (Index j = 0; j < n; ++j) {
    to.col(j).segment(j, n - j) = from.col(j).segment(j, n - j);
  }
}

}  // namespace

Covariance& Covariance::operator=(const Covariance& other) {
  if (this == &other) {
    return *this;
  }
  size_ = other.size_;
  if (data_.rows() < size_) {
    data_.resize(other.data_.rows(), other.data_.cols());
  }
  copy_lower(other.data_, size_, data_);
  return *this;
}

MatrixXd Covariance::dense() const {
  MatrixXd full = data_.topLeftCorner(size_, size_);
  full.triangularView<Eigen::StrictlyUpper>() = full.transpose();
  return full;
}

MatrixXd Covariance::block(Index row, Index col, Index rows, Index cols) const {
  MatrixXd out(rows, cols);
  for (Index j = 0; j < cols; ++j) {
    for (Index i = 0; i < rows; ++i) {
      out(i, j) = data_(std::max(row + i, col + j), std::min(row + i, col + j));
    }
  }
  return out;
}

void Covariance::set_diagonal_block(Index start, const Eigen::Ref<const MatrixXd>& value) {
  data_.block(start, start, value.rows(), value.cols()).triangularView<Eigen::Lower>() = value;
}

void Covariance::assign(const Eigen::Ref<const MatrixXd>& value) {
  size_ = 0;
  reserve(value.rows());
  size_ = value.rows();
  set_diagonal_block(0, value);
}

MatrixXd Covariance::times(const Eigen::Ref<const MatrixXd>& X) const {
  return data_.topLeftCorner(size_, size_).selfadjointView<Eigen::Lower>() * X;
}

void Covariance::gather(std::span<const Index> starts, MatrixXd& columns) const {
  columns.resize(size_, kTriplet * static_cast<Index>(starts.size()));
  Index out = 0;
  for (const Index start : starts) {
    auto target = columns.middleCols<kTriplet>(out);
    target.topRows(start) = data_.block(start, 0, kTriplet, start).transpose();
    target.middleRows<kTriplet>(start) = diagonal_block<kTriplet>(start);
    const Index below = size_ - start - kTriplet;
    target.bottomRows(below) = data_.block(start + kTriplet, start, below, kTriplet);
    out += kTriplet;
  }
}

void Covariance::scatter(std::span<const Index> starts, const Eigen::Ref<const MatrixXd>& columns) {
  Index in = 0;
  for (const Index start : starts) {
    const auto source = columns.middleCols<kTriplet>(in);
    data_.block(start, 0, kTriplet, start) = source.topRows(start).transpose();
    data_.block<kTriplet, kTriplet>(start, start) = source.middleRows<kTriplet>(start);
    const Index below = size_ - start - kTriplet;
    data_.block(start + kTriplet, start, below, kTriplet) = source.bottomRows(below);
    in += kTriplet;
  }
}

void Covariance::swap_triplets(Index a, Index b) {
  if (a == b) {
    return;
  }
  const std::array<Index, 2> both = {a, b};
  MatrixXd columns;
  gather(both, columns);
  columns.leftCols<kTriplet>().swap(columns.rightCols<kTriplet>());
  columns.middleRows<kTriplet>(a).swap(columns.middleRows<kTriplet>(b));
  scatter(both, columns);
}

void Covariance::subtract_outer(const Eigen::Ref<const MatrixXd>& W) {
  limber::add_outer(data_.topLeftCorner(size_, size_), -1.0, W);
}

void Covariance::add_outer(const Eigen::Ref<const MatrixXd>& W) {
  limber::add_outer(data_.topLeftCorner(size_, size_), 1.0, W);
}

void Covariance::add_symmetric_product(const Eigen::Ref<const MatrixXd>& U,
                                       const Eigen::Ref<const MatrixXd>& V) {
  // [U V] [V U]ᵀ, so that P is walked over once.
  MatrixXd left(size_, 2 * U.cols()), right(size_, 2 * U.cols());
  left << U, V;
  right << V, U;
  add_lower_product(data_.topLeftCorner(size_, size_), left, transposed(right));
}

void Covariance::transform_triplet(Index start, const Eigen::Matrix3d& M) {
  const Index below = size_ - start - kTriplet;
  auto row = data_.block(start, 0, kTriplet, start);
  auto column = data_.block(start + kTriplet, start, below, kTriplet);
  row = (M * row).eval();
  column = (column * M.transpose()).eval();
  set_diagonal_block(start, M * diagonal_block<kTriplet>(start) * M.transpose());
}

void Covariance::propagate_leading(const Eigen::Ref<const MatrixXd>& Phi,
                                   const Eigen::Ref<const MatrixXd>& Q) {
  const Index k = Phi.rows();
  const MatrixXd P = data_.topLeftCorner(k, k).selfadjointView<Eigen::Lower>();
  set_diagonal_block(0, congruence(Phi, P) + Q);
  propagate_cross(Phi);
}

void Covariance::propagate_cross(const Eigen::Ref<const MatrixXd>& Phi) {
  const Index k = Phi.rows();
  auto cross = data_.block(k, 0, size_ - k, k);
  cross = multiply(cross, transposed(Phi));
}

void Covariance::couple_leading(const Eigen::Ref<const MatrixXd>& U, Index from) {
  const Index k = U.rows();
  MatrixXd columns;
  gather(std::array{from}, columns);
  const MatrixXd own = U * columns.topRows(k).transpose();
  const MatrixXd leading = own + own.transpose() + U * columns.middleRows<kTriplet>(from) * U.transpose();
  data_.topLeftCorner(k, k).triangularView<Eigen::Lower>() += leading;
  data_.block(k, 0, size_ - k, k) += columns.bottomRows(size_ - k) * U.transpose();
}

void Covariance::reserve(Index size) {
  if (size > data_.rows()) {
    const Index capacity = std::max(size, data_.rows() + data_.rows() / 2 + 64);
    MatrixXd grown(capacity, capacity);
    copy_lower(data_, size_, grown);
    data_.swap(grown);
  }
}

Index Covariance::append(Index count) {
  const Index first = size_;
  reserve(size_ + count);
  size_ += count;
  data_.block(first, 0, count, size_).setZero();
  return first;
}

Index Covariance::remove_triplet(Index start) {
  const Index last = size_ - kTriplet;
  if (start != last) {
    const Eigen::Matrix3d moved = diagonal_block<kTriplet>(last);
    const Index between = last - start - kTriplet;
    data_.block(start, 0, kTriplet, start) = data_.block(last, 0, kTriplet, start);
    data_.block(start + kTriplet, start, between, kTriplet) =
        data_.block(last, start + kTriplet, kTriplet, between).transpose();
    set_diagonal_block(start, moved);
  }
  size_ = last;
  return last;
}

}  // namespace limber
