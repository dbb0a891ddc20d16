// SPDX-License-Identifier: MIT
#include "limber/core/linear_measurement.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd SparseJacobian::dense(Index rows, Index cols) const {
  MatrixXd out = MatrixXd::Zero(rows, cols);
  for (const Block& block : blocks) {
    out.block(block.row, block.col, block.value.rows(), kTriplet) += block.value;
  }
  return out;
}

LinearMeasurement LinearMeasurement::subset(const std::vector<bool>& kept) const {
  LinearMeasurement out;
  std::vector<Index> new_row(static_cast<std::size_t>(rows()), -1);
  Index m = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (!kept[g]) {
      continue;
    }
    out.groups.push_back({m, groups[g].rows, groups[g].own});
    for (Index k = 0; k < groups[g].rows; ++k) {
      new_row[static_cast<std::size_t>(groups[g].row + k)] = m++;
    }
  }
  out.residual.resize(m);
  out.sigma.resize(m);
  out.D.resize(D.cols() > 0 ? m : 0, D.cols());
  for (Index row = 0; row < rows(); ++row) {
    const Index to = new_row[static_cast<std::size_t>(row)];
    if (to >= 0) {
      out.residual(to) = residual(row);
      out.sigma(to) = sigma(row);
      if (D.cols() > 0) {
        out.D.row(to) = D.row(row);
      }
    }
  }
  for (const SparseJacobian::Block& block : H.blocks) {
    const Index to = new_row[static_cast<std::size_t>(block.row)];
    if (to >= 0) {
      out.H.blocks.push_back({to, block.col, block.value});
    }
  }
  return out;
}

}  // namespace limber
