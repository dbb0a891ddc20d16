// SPDX-License-Identifier: MIT
#include "limber/update/innovation.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

void check(const Covariance& P, const LinearMeasurement& z) {
  const Index m = z.rows();
  const auto shapes = [&] {
    return "r has " + std::to_string(m) + " rows, sigma " + std::to_string(z.sigma.size()) + ", D " +
           std::to_string(z.D.rows()) + "x" + std::to_string(z.D.cols()) + ", P is " +
           std::to_string(P.size()) + " wide";
  };
  if (z.sigma.size() != m || (z.D.cols() > 0 && z.D.rows() != m) || m % 2 != 0) {
    throw std::invalid_argument("measurement: shapes disagree: " + shapes());
  }
  for (const SparseJacobian::Block& block : z.H.blocks) {
    if (block.row < 0 || block.row + 2 > m || block.col < 0 || block.col + kTriplet > P.size()) {
      throw std::invalid_argument("measurement: block of H at (" + std::to_string(block.row) + ", " +
                                  std::to_string(block.col) + ") lies outside: " + shapes());
    }
    if (!block.value.allFinite()) {
      throw std::invalid_argument("measurement: block of H at (" + std::to_string(block.row) + ", " +
                                  std::to_string(block.col) + ") is not finite");
    }
  }
  if (!z.residual.allFinite() || !(z.sigma.array() > 0.0).all() || !z.sigma.allFinite() || !z.D.allFinite()) {
    throw std::invalid_argument("measurement: expected finite r and D and positive sigma");
  }
}

/// The distinct columns that H touches, sorted.
std::vector<Index> touched_columns(const SparseJacobian& H) {
  std::vector<Index> columns;
  columns.reserve(H.blocks.size());
  for (const SparseJacobian::Block& block : H.blocks) {
    columns.push_back(block.col);
  }
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  return columns;
}

}  // namespace

Innovation form_innovation(const Covariance& P, const LinearMeasurement& z) {
  check(P, z);
  const Index m = z.rows();
  const Eigen::VectorXd weight = z.sigma.cwiseInverse();
  Innovation out;
  out.r = z.residual.cwiseProduct(weight);
  out.D = z.D.cols() > 0 ? MatrixXd(weight.asDiagonal() * z.D) : MatrixXd(m, 0);

  const std::vector<Index> columns = touched_columns(z.H);
  std::vector<Index> place(static_cast<std::size_t>(P.size()), -1);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    place[static_cast<std::size_t>(columns[k])] = kTriplet * static_cast<Index>(k);
  }
  MatrixXd gathered;
  P.gather(columns, gathered);

  std::vector<Eigen::Matrix<double, 2, kTriplet>> whitened;
  whitened.reserve(z.H.blocks.size());
  out.PHt.setZero(P.size(), m);
  for (const SparseJacobian::Block& block : z.H.blocks) {
    whitened.push_back(weight.segment<2>(block.row).asDiagonal() * block.value);
    const Index at = place[static_cast<std::size_t>(block.col)];
    out.PHt.middleCols<2>(block.row).noalias() +=
        gathered.middleCols<kTriplet>(at).lazyProduct(whitened.back().transpose());
  }

  // S = (P Hᵀ)ᵀ Hᵀ + I, from the few rows of P Hᵀ that H touches.
  MatrixXd rows(m, kTriplet * static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) {
    rows.middleCols<kTriplet>(kTriplet * static_cast<Index>(k)) =
        out.PHt.middleRows<kTriplet>(columns[k]).transpose();
  }
  out.S.setIdentity(m, m);
  for (std::size_t b = 0; b < z.H.blocks.size(); ++b) {
    const Index at = place[static_cast<std::size_t>(z.H.blocks[b].col)];
    out.S.middleCols<2>(z.H.blocks[b].row).noalias() +=
        rows.middleCols<kTriplet>(at).lazyProduct(whitened[b].transpose());
  }
  return out;
}

}  // namespace limber
