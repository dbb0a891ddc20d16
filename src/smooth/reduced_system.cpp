// SPDX-License-Identifier: MIT
#include "reduced_system.hpp"

#include <ceres/crs_matrix.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "block_tridiagonal.hpp"
#include "limber/core/factors.hpp"
#include "limber/smooth/unsolvable_error.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

namespace {

constexpr Index kColumnsAtATime = 96;

[[noreturn]] void fail(const char* what) {
  throw UnsolvableError(std::string("smoother: ") + what + " not determined by the recording");
}

/// The Jacobian with its columns in order of elimination: [landmarks | chain | kept].
struct Linearised {
  ceres::CRSMatrix J;
  VectorXd r;
  int chain_begin = 0, kept_begin = 0;
  std::map<const double*, int> begin;  // of kept blocks, from kept_begin
};

Linearised linearise(ceres::Problem& problem, const Columns& columns) {
  Linearised out;
  ceres::Problem::EvaluateOptions options;
  int at = 0;
  const auto add = [&](const std::vector<double*>& blocks) {
    for (double* block : blocks) {
      options.parameter_blocks.push_back(block);
      at += problem.ParameterBlockTangentSize(block);
    }
    return at;
  };
  out.chain_begin = add(columns.landmarks);
  out.kept_begin = add(columns.chain);
  for (double* block : columns.kept) {
    out.begin[block] = at - out.kept_begin;
    add({block});
  }
  std::vector<double> residuals;
  if (!problem.Evaluate(options, nullptr, &residuals, nullptr, &out.J)) {
    fail("the residuals are");
  }
  out.r = Eigen::Map<VectorXd>(residuals.data(), static_cast<Index>(residuals.size()));
  return out;
}

/// One landmark: its own information, and what couples it with kept unknowns.
struct LandmarkPart {
  Matrix3d own = Matrix3d::Zero();
  Vector3d gradient = Vector3d::Zero();
  std::map<int, Vector3d> coupling;  // by column of the kept part
};

/// Adds JᵀJ and Jᵀr of all rows.
struct Accumulator {
  Accumulator(const Linearised& l, const Columns& columns)
      : linearised(l),
        landmarks(static_cast<std::size_t>(l.chain_begin / 3)),
        chain_gradient(VectorXd::Zero(l.kept_begin - l.chain_begin)) {
    const Index kept = l.J.num_cols - l.kept_begin;
    system.chain.resize(chain_gradient.size(), chain_gradient.size());
    system.kept_chain.resize(kept, chain_gradient.size());
    system.information = MatrixXd::Zero(kept, kept);
    system.gradient = VectorXd::Zero(kept);
    system.begin = l.begin;
    if (columns.rig == nullptr) return;  // nobody asks for cells
    rig_begin = l.begin.at(columns.rig);
    const CellPart none{VectorXd::Zero(kept)};
    for (const int cell : columns.cells) {
      cell_parts.push_back(&system.of_cell.try_emplace(cell, none).first->second);
    }
  }

  /// Adds to what the points of a cell have: kept column, and where both are of the rig their product.
  void add_to_cell(CellPart& cell, int a, int b, double product) const {
    const int row = a - rig_begin, col = b - rig_begin;
    if (row >= 0 && row < 6 && col >= 0 && col < 6) cell.rig(row, col) += product;
  }

  void add_rows() {
    std::vector<Eigen::Triplet<double>> of_chain, of_both;
    const auto& J = linearised.J;
    for (int row = 0; row < J.num_rows; ++row) {
      const auto first = static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row)]);
      const auto last = static_cast<std::size_t>(J.rows[static_cast<std::size_t>(row) + 1]);
      const double r = linearised.r(row);
      CellPart* const cell = cell_of_row(first, last);
      for (std::size_t i = first; i < last; ++i) {
        add_gradient(J.cols[i], J.values[i] * r);
        const int kept = J.cols[i] - linearised.kept_begin;
        if (cell != nullptr && kept >= 0) cell->gradient(kept) += J.values[i] * r;
        for (std::size_t k = first; k < last; ++k) {
          add_product(J.cols[i], J.cols[k], J.values[i] * J.values[k], of_chain, of_both);
          if (cell != nullptr) {
            add_to_cell(*cell, kept, J.cols[k] - linearised.kept_begin, J.values[i] * J.values[k]);
          }
        }
      }
    }
    system.chain.setFromTriplets(of_chain.begin(), of_chain.end());
    system.kept_chain.setFromTriplets(of_both.begin(), of_both.end());
  }

  /// Part of the cell of the landmark among the columns of a row; null if there is none.
  [[nodiscard]] CellPart* cell_of_row(std::size_t first, std::size_t last) const {
    for (std::size_t i = first; i < last; ++i) {
      const int col = linearised.J.cols[i];
      if (col < linearised.chain_begin && !cell_parts.empty())
        return cell_parts[static_cast<std::size_t>(col / 3)];
    }
    return nullptr;
  }

  void add_gradient(int col, double value) {
    if (col < linearised.chain_begin) {
      landmarks[static_cast<std::size_t>(col / 3)].gradient(col % 3) += value;
    } else if (col < linearised.kept_begin) {
      chain_gradient(col - linearised.chain_begin) += value;
    } else {
      system.gradient(col - linearised.kept_begin) += value;
    }
  }

  void add_product(int a, int b, double value, std::vector<Eigen::Triplet<double>>& of_chain,
                   std::vector<Eigen::Triplet<double>>& of_both) {
    const int chain_begin = linearised.chain_begin, kept_begin = linearised.kept_begin;
    if (a >= kept_begin) {
      if (b >= kept_begin && a >= b) {
        system.information(a - kept_begin, b - kept_begin) += value;
      } else if (b >= chain_begin && b < kept_begin) {
        of_both.emplace_back(a - kept_begin, b - chain_begin, value);
      } else if (b < chain_begin) {
        landmarks[static_cast<std::size_t>(b / 3)]
            .coupling.try_emplace(a - kept_begin, Vector3d::Zero())
            .first->second(b % 3) += value;
      }
    } else if (a >= chain_begin) {
      if (b >= chain_begin && b < kept_begin) {
        of_chain.emplace_back(a - chain_begin, b - chain_begin, value);
      }
    } else if (b < chain_begin) {
      landmarks[static_cast<std::size_t>(a / 3)].own(a % 3, b % 3) += value;
    }
  }

  void eliminate_landmarks() {
    for (std::size_t n = 0; n < landmarks.size(); ++n) {
      const LandmarkPart& landmark = landmarks[n];
      const Eigen::LLT<Matrix3d> llt(landmark.own);
      if (llt.info() != Eigen::Success) {
        fail("the place of a point is");
      }
      const Vector3d g = llt.matrixL().solve(landmark.gradient);
      std::vector<std::pair<int, Vector3d>> whitened;
      for (const auto& [col, value] : landmark.coupling) {
        whitened.emplace_back(col, llt.matrixL().solve(value));
      }
      for (std::size_t j = 0; j < whitened.size(); ++j) {
        const auto& [col, y] = whitened[j];
        system.gradient(col) -= y.dot(g);
        if (!cell_parts.empty()) {
          cell_parts[n]->gradient(col) -= y.dot(g);
          for (const auto& [other, x] : whitened) add_to_cell(*cell_parts[n], other, col, -x.dot(y));
        }
        for (std::size_t i = j; i < whitened.size(); ++i) {
          system.information(whitened[i].first, col) -= whitened[i].second.dot(y);
        }
      }
    }
  }

  void eliminate_chain() {
    const Sparse &chain = system.chain, &kept_chain = system.kept_chain;
    if (chain.rows() == 0) {
      return;
    }
    const Eigen::SimplicialLDLT<Sparse> ldlt(chain);
    if (ldlt.info() != Eigen::Success || !(ldlt.vectorD().minCoeff() > 0.0)) {
      fail("velocities or biases are");
    }
    system.gradient -= kept_chain * ldlt.solve(chain_gradient);
    const Sparse chain_kept = kept_chain.transpose();
    for (Index col = 0; col < kept_chain.rows(); col += kColumnsAtATime) {
      const Index n = std::min(kColumnsAtATime, kept_chain.rows() - col);
      const MatrixXd rhs = chain_kept.middleCols(col, n);
      system.information.middleCols(col, n) -= kept_chain * ldlt.solve(rhs);
    }
  }

  const Linearised& linearised;
  std::vector<LandmarkPart> landmarks;
  VectorXd chain_gradient;
  ReducedSystem system;
  std::vector<CellPart*> cell_parts;  // of each landmark, in the system
  int rig_begin = -1;                 // in the kept part
};

}  // namespace

ReducedSystem reduce(ceres::Problem& problem, const Columns& columns) {
  const Linearised linearised = linearise(problem, columns);
  Accumulator sums(linearised, columns);
  sums.add_rows();
  sums.eliminate_landmarks();
  sums.eliminate_chain();
  return std::move(sums.system);
}

Marginals::Marginals(ReducedSystem system)
    : system_(std::move(system)), scale_(system_.information.diagonal().cwiseSqrt().cwiseInverse()) {
  MatrixXd& S = system_.information;
  if (!scale_.allFinite()) {
    fail("the states are");
  }
  S = (scale_.asDiagonal() * S * scale_.asDiagonal()).eval();
  const Cholesky cholesky(std::move(S));
  if (!cholesky.succeeded()) {
    fail("the states are");
  }
  const MatrixXd& L = cholesky.factor();
  inverse_factor_ = MatrixXd::Identity(L.rows(), L.rows());
  // L⁻¹ is lower triangular: columns in groups, each from its own row on.
  for (Index col = 0; col < L.rows(); col += kColumnsAtATime) {
    const Index rest = L.rows() - col, n = std::min(kColumnsAtATime, rest);
    solve_lower(L.bottomRightCorner(rest, rest), inverse_factor_.block(col, col, rest, n));
  }
  S.resize(0, 0);
}

MatrixXd Marginals::of(const double* block, int size) const {
  const Index at = system_.at(block);
  const Index rest = inverse_factor_.rows() - at;
  const auto part = inverse_factor_.block(at, at, rest, size);
  const auto scale = scale_.segment(at, size);
  return scale.asDiagonal() * multiply(transposed(part), part) * scale.asDiagonal();
}

MatrixXd Marginals::of(const std::vector<Block>& blocks) const {
  Index size = 0;
  for (const Block& block : blocks) {
    size += block.size;
  }
  MatrixXd columns(inverse_factor_.rows(), size);
  VectorXd scale(size);
  Index at = 0;
  for (const Block& block : blocks) {
    columns.middleCols(at, block.size) = inverse_factor_.middleCols(system_.at(block.at), block.size);
    scale.segment(at, block.size) = scale_.segment(system_.at(block.at), block.size);
    at += block.size;
  }
  return scale.asDiagonal() * multiply(transposed(columns), columns) * scale.asDiagonal();
}

std::vector<MatrixXd> Marginals::of_chain(Index width) const {
  if (system_.chain.rows() == 0) {
    return {};
  }
  // With the chain's own C, its coupling B with what is kept and the covariance S of that, the chain's is
  // C⁻¹ + C⁻¹ Bᵀ S B C⁻¹. S column by column, of which the lower triangle and half the diagonal are enough:
  // the rest is the transpose.
  const BlockTridiagonal chain(system_.chain, width);
  if (!chain.succeeded()) {
    fail("velocities or biases are");
  }
  std::vector<MatrixXd> out = chain.inverse_diagonal();
  const Sparse chain_kept = system_.kept_chain.transpose();
  const Index kept = inverse_factor_.rows();
  for (Index col = 0; col < kept; col += kColumnsAtATime) {
    const Index rest = kept - col, n = std::min(kColumnsAtATime, rest);
    MatrixXd lower = multiply(transposed(inverse_factor_.bottomRightCorner(rest, rest)),
                              inverse_factor_.block(col, col, rest, n));
    lower.topRows(n) *= 0.5;
    lower = (scale_.tail(rest).asDiagonal() * lower * scale_.segment(col, n).asDiagonal()).eval();
    MatrixXd left = chain_kept.rightCols(rest) * lower, right = chain_kept.middleCols(col, n);
    chain.solve(left);
    chain.solve(right);
    for (std::size_t j = 0; j < out.size(); ++j) {
      const Index at = static_cast<Index>(j) * width;
      const MatrixXd half = left.middleRows(at, width) * right.middleRows(at, width).transpose();
      out[j] += half + half.transpose();
    }
  }
  return out;
}

VectorXd Marginals::of_step(const double* block, int size, const VectorXd& gradient) const {
  const Index at = system_.at(block);
  const Index rest = inverse_factor_.rows() - at;
  const VectorXd whitened = inverse_factor_.triangularView<Eigen::Lower>() * scale_.cwiseProduct(gradient);
  const auto part = inverse_factor_.block(at, at, rest, size);
  return scale_.segment(at, size).cwiseProduct(part.transpose() * whitened.tail(rest));
}

}  // namespace limber::detail
