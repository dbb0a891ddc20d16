// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/problem.h>

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <map>
#include <vector>

#include "least_squares.hpp"

/// What a least-squares problem says of some of its unknowns, once all others are eliminated.
namespace limber::detail {

/// Share of some points in a reduced system.
struct CellPart {
  Eigen::VectorXd gradient;                                               ///< K
  Eigen::Matrix<double, 6, 6> rig = Eigen::Matrix<double, 6, 6>::Zero();  ///< information of Columns::rig
};

/// The problem at its present values: JᵀJ and Jᵀr of the kept unknowns after landmarks and chain are
/// eliminated (Schur complements).
struct ReducedSystem {
  Eigen::MatrixXd information;         ///< K×K; lower triangle alone is set
  Eigen::VectorXd gradient;            ///< K: of half the squared residuals
  std::map<int, CellPart> of_cell;     ///< what the points of each image cell have in it
  std::map<const double*, int> begin;  ///< where each block's tangent begins
  /// Of JᵀJ: the chain's own part, and its rows of what is kept (K × chain).
  Eigen::SparseMatrix<double> chain, kept_chain;

  [[nodiscard]] int at(const double* block) const { return begin.at(block); }
};

/// @throws UnsolvableError if what is eliminated is not determined
[[nodiscard]] ReducedSystem reduce(ceres::Problem& problem, const Columns& columns);

/// A parameter block and how wide its tangent is.
struct Block {
  const double* at = nullptr;
  int size = 0;
};

/// Blocks on the diagonal of the covariance of what is kept, each as wide as its tangent.
/// @throws UnsolvableError if something kept is not determined
class Marginals {
 public:
  explicit Marginals(ReducedSystem system);
  [[nodiscard]] Eigen::MatrixXd of(const double* block, int size) const;
  /// Of several blocks together.
  [[nodiscard]] Eigen::MatrixXd of(const std::vector<Block>& blocks) const;
  /// Those of the chain's blocks, all of one width, in their order. Takes as long as the construction.
  [[nodiscard]] std::vector<Eigen::MatrixXd> of_chain(Eigen::Index width) const;
  /// Part of a block in the covariance times a gradient of what is kept.
  [[nodiscard]] Eigen::VectorXd of_step(const double* block, int size, const Eigen::VectorXd& gradient) const;
  /// Of the points of each image cell: ReducedSystem::of_cell.
  [[nodiscard]] const std::map<int, CellPart>& cells() const { return system_.of_cell; }

 private:
  ReducedSystem system_;
  Eigen::MatrixXd inverse_factor_;  // L⁻¹, information = L Lᵀ in scaled units
  Eigen::VectorXd scale_;
};

}  // namespace limber::detail
