// SPDX-License-Identifier: MIT
#include "block_tridiagonal.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;

BlockTridiagonal::BlockTridiagonal(const Eigen::SparseMatrix<double>& matrix, Index width) : width_(width) {
  const Index n = matrix.rows() / width;
  for (Index j = 0; j < n; ++j) {
    diagonal_.emplace_back(matrix.block(j * width, j * width, width, width));
    if (j + 1 < n) {
      lower_.emplace_back(matrix.block((j + 1) * width, j * width, width, width));
    }
    MatrixXd left = diagonal_.back();
    if (j > 0) {
      const MatrixXd& coupling = lower_[static_cast<std::size_t>(j - 1)];
      left -= coupling * from_first_.back().solve(coupling.transpose());
    }
    succeeded_ = succeeded_ && from_first_.emplace_back(left).info() == Eigen::Success;
  }
}

void BlockTridiagonal::solve(MatrixXd& B) const {
  const auto block = [&](std::size_t j) { return B.middleRows(static_cast<Index>(j) * width_, width_); };
  const std::size_t n = diagonal_.size();
  for (std::size_t j = 0; j < n; ++j) {
    if (j > 0) {
      block(j).noalias() -= lower_[j - 1] * block(j - 1);
    }
    from_first_[j].solveInPlace(block(j));
  }
  for (std::size_t j = n; j-- > 1;) {
    MatrixXd step = lower_[j - 1].transpose() * block(j);
    from_first_[j - 1].solveInPlace(step);
    block(j - 1) -= step;
  }
}

std::vector<MatrixXd> BlockTridiagonal::inverse_diagonal() const {
  const MatrixXd identity = MatrixXd::Identity(width_, width_);
  std::vector<MatrixXd> out(diagonal_.size());
  for (std::size_t j = out.size(); j-- > 0;) {
    // A_jj⁻¹ once those before it are eliminated, and what the block behind it adds.
    out[j] = from_first_[j].solve(identity);
    if (j + 1 < out.size()) {
      const MatrixXd gain = from_first_[j].solve(lower_[j].transpose());
      out[j] += gain * out[j + 1] * gain.transpose();
    }
  }
  return out;
}

}  // namespace limber::detail
