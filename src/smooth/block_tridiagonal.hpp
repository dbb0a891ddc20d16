// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

namespace limber::detail {

/// @brief A symmetric positive definite matrix of square blocks of which each is coupled with its neighbours
/// alone, factorised block by block.
class BlockTridiagonal {
 public:
  /// @param matrix  n·width rows; what lies beyond the neighbours is not read
  /// @param width   of a block
  BlockTridiagonal(const Eigen::SparseMatrix<double>& matrix, Eigen::Index width);

  /// Whether the matrix is positive definite; if not, nothing else may be asked.
  [[nodiscard]] bool succeeded() const { return succeeded_; }
  /// How many blocks are on the diagonal.
  [[nodiscard]] Eigen::Index blocks() const { return static_cast<Eigen::Index>(diagonal_.size()); }
  /// A⁻¹ B, in the place of B.
  void solve(Eigen::MatrixXd& B) const;
  /// The blocks on the diagonal of A⁻¹.
  [[nodiscard]] std::vector<Eigen::MatrixXd> inverse_diagonal() const;

 private:
  Eigen::Index width_;
  bool succeeded_ = true;
  std::vector<Eigen::MatrixXd> diagonal_, lower_;        ///< A_jj; A_(j+1)j
  std::vector<Eigen::LLT<Eigen::MatrixXd>> from_first_;  ///< of A_jj once all blocks before it are eliminated
};

}  // namespace limber::detail
