// SPDX-License-Identifier: MIT
#include "limber/update/innovation.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Groups have to be a partition of the rows.
void check_groups(const LinearMeasurement& z) {
  Index next = 0;
  for (const RowGroup& group : z.groups) {
    if (group.row != next || group.rows <= 0) {
      throw std::invalid_argument("measurement: expected a group that begins at row " + std::to_string(next) +
                                  ", but one has " + std::to_string(group.rows) + " rows from " +
                                  std::to_string(group.row));
    }
    next += group.rows;
  }
  if (next != z.rows()) {
    throw std::invalid_argument("measurement: its groups end at row " + std::to_string(next) + " of " +
                                std::to_string(z.rows()));
  }
}

}  // namespace

void check(const Covariance& P, const LinearMeasurement& z) {
  const Index m = z.rows();
  const auto shapes = [&] {
    return "r has " + std::to_string(m) + " rows, sigma " + std::to_string(z.sigma.size()) + ", D " +
           std::to_string(z.D.rows()) + "x" + std::to_string(z.D.cols()) + ", P is " +
           std::to_string(P.size()) + " wide";
  };
  if (z.sigma.size() != m || (z.D.cols() > 0 && z.D.rows() != m)) {
    throw std::invalid_argument("measurement: shapes disagree: " + shapes());
  }
  for (const SparseJacobian::Block& block : z.H.blocks) {
    if (block.row < 0 || block.row + block.value.rows() > m || block.col < 0 ||
        block.col + kTriplet > P.size()) {
      throw std::invalid_argument("measurement: block of H at (" + std::to_string(block.row) + ", " +
                                  std::to_string(block.col) + ") lies outside: " + shapes());
    }
    if (!block.value.allFinite()) {
      throw std::invalid_argument("measurement: block of H at (" + std::to_string(block.row) + ", " +
                                  std::to_string(block.col) + ") is not finite");
    }
  }
  if (z.stateless.D.rows() != z.stateless.residual.size() ||
      (z.stateless.D.rows() > 0 && z.stateless.D.cols() != z.D.cols())) {
    throw std::invalid_argument("measurement: shapes of its stateless rows disagree: r has " +
                                std::to_string(z.stateless.residual.size()) + " rows, D " +
                                std::to_string(z.stateless.D.rows()) + "x" +
                                std::to_string(z.stateless.D.cols()) + ", the others' has " +
                                std::to_string(z.D.cols()) + " columns");
  }
  if (!z.residual.allFinite() || !(z.sigma.array() > 0.0).all() || !z.sigma.allFinite() || !z.D.allFinite() ||
      !z.stateless.residual.allFinite() || !z.stateless.D.allFinite()) {
    throw std::invalid_argument("measurement: expected finite r and D and positive sigma");
  }
  if (!z.groups.empty()) {
    check_groups(z);
  }
}

namespace {

/// Blocks of H in the order of their columns, divided by the noise of their rows.
std::vector<SparseJacobian::Block> whitened_by_column(const LinearMeasurement& z,
                                                      const Eigen::VectorXd& weight) {
  std::vector<SparseJacobian::Block> blocks = z.H.blocks;
  for (SparseJacobian::Block& block : blocks) {
    block.value.array().colwise() *= weight.segment(block.row, block.value.rows()).array();
  }
  std::stable_sort(blocks.begin(), blocks.end(), [](const auto& a, const auto& b) { return a.col < b.col; });
  return blocks;
}

/// out += columns Bᵀ in the columns that belong to the block's rows. columns: k×3, out: k×m.
template <typename Columns>
void add_product(const Columns& columns, const SparseJacobian::Block& block, MatrixXd& out) {
  const auto add = [&](auto rows) {  // fixed, for the sake of speed
    out.middleCols<rows()>(block.row).noalias() +=
        columns.lazyProduct(block.value.template topRows<rows()>().transpose());
  };
  switch (block.value.rows()) {
    case 1:
      return add(std::integral_constant<int, 1>());
    case 2:
      return add(std::integral_constant<int, 2>());
    default:
      return add(std::integral_constant<int, kTriplet>());
  }
}

}  // namespace

Innovation form_innovation(const Covariance& P, const LinearMeasurement& z) {
  check(P, z);
  const Index m = z.rows();
  const Eigen::VectorXd weight = z.sigma.cwiseInverse();
  Innovation out;
  out.stateless = z.stateless;
  if (z.stateless.residual.size() == 0) {
    out.stateless.D.resize(0, z.D.cols());
  }
  out.noise = z.noise;
  out.r = z.residual.cwiseProduct(weight);
  out.D = z.D.cols() > 0 ? MatrixXd(weight.asDiagonal() * z.D) : MatrixXd(m, 0);

  const std::vector<SparseJacobian::Block> blocks = whitened_by_column(z, weight);
  out.PHt.setZero(P.size(), m);
  MatrixXd columns;  // of P, one triplet at a time
  Index gathered = -1;
  for (const SparseJacobian::Block& block : blocks) {
    if (block.col != gathered) {
      gathered = block.col;
      P.gather(std::array<Index, 1>{gathered}, columns);
    }
    add_product(columns.leftCols<kTriplet>(), block, out.PHt);
  }

  // S = (P Hᵀ)ᵀ Hᵀ + I, from the few rows of P Hᵀ that H touches.
  out.S.setIdentity(m, m);
  Eigen::Matrix<double, Eigen::Dynamic, kTriplet> rows(m, kTriplet);
  gathered = -1;
  for (const SparseJacobian::Block& block : blocks) {
    if (block.col != gathered) {
      gathered = block.col;
      rows = out.PHt.middleRows<kTriplet>(gathered).transpose();
    }
    add_product(rows, block, out.S);
  }
  return out;
}

}  // namespace limber
