// SPDX-License-Identifier: MIT
#include "limber/update/innovation.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "limber/core/dense.hpp"
#include "limber/core/divergence_error.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Groups have to be a partition of the rows.
void check_groups(const LinearMeasurement& z) {
  Index next = 0;
  for (const RowGroup& group : z.groups) {
    if (group.row != next || group.rows <= 0 || group.fourth >= 0) {
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
      throw DivergenceError("measurement: block of H at (" + std::to_string(block.row) + ", " +
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
  if (!(z.sigma.array() > 0.0).all() || !z.sigma.allFinite()) {
    throw std::invalid_argument("measurement: expected positive sigma");
  }
  if (!z.residual.allFinite() || !z.D.allFinite() || !z.stateless.residual.allFinite() ||
      !z.stateless.D.allFinite()) {
    throw DivergenceError("measurement: r or D is not finite");
  }
  if (!z.groups.empty()) {
    check_groups(z);
  }
}

namespace {

using Block = SparseJacobian::Block;

/// H, divided by the noise, column by column: those that many rows look at (the pose, an anchor) as a matrix,
/// for the sake of speed, the others (a point's own) as blocks.
class ColumnsOfH {
 public:
  ColumnsOfH(const LinearMeasurement& z, const Eigen::VectorXd& weight) : blocks_(z.H.blocks) {
    for (Block& block : blocks_) {
      block.value.array().colwise() *= weight.segment(block.row, block.value.rows()).array();
    }
    std::stable_sort(blocks_.begin(), blocks_.end(),
                     [](const Block& a, const Block& b) { return a.col < b.col; });
    std::vector<std::span<const Block>> shared;
    for (std::span<const Block> rest(blocks_); !rest.empty();) {
      const Index col = rest.front().col;
      const auto end =
          std::find_if(rest.begin(), rest.end(), [&](const Block& block) { return block.col != col; });
      const std::span<const Block> column = rest.first(static_cast<std::size_t>(end - rest.begin()));
      (column.size() >= kMany ? shared : own_).push_back(column);
      rest = rest.subspan(column.size());
    }
    shared_.setZero(z.rows(), kTriplet * static_cast<Index>(shared.size()));
    for (const std::span<const Block> column : shared) {
      const Index at = kTriplet * static_cast<Index>(shared_starts_.size());
      shared_starts_.push_back(column.front().col);
      for (const Block& block : column) {
        shared_.block(block.row, at, block.value.rows(), kTriplet) += block.value;
      }
    }
  }

  [[nodiscard]] const std::vector<Index>& shared_starts() const { return shared_starts_; }
  [[nodiscard]] const MatrixXd& shared() const { return shared_; }  // m × 3|shared_starts|

  /// f(start of the triplet, its blocks) for each of the others.
  template <typename Function>
  void for_each_own(Function f) const {
    for (const std::span<const Block> column : own_) {
      f(column.front().col, column);
    }
  }

 private:
  static constexpr std::size_t kMany = 16;  // blocks

  std::vector<Block> blocks_;
  std::vector<std::span<const Block>> own_;
  std::vector<Index> shared_starts_;
  MatrixXd shared_;
};

/// out += columns Bᵀ for each block, in the columns that belong to its rows. columns: k×3, out: k×m.
template <typename Columns>
void add_products(const Columns& columns, std::span<const Block> blocks, MatrixXd& out) {
  for (const Block& block : blocks) {
    const auto add = [&](auto rows) {  // fixed, for the sake of speed
      out.middleCols<rows()>(block.row).noalias() +=
          columns.lazyProduct(block.value.template topRows<rows()>().transpose());
    };
    switch (block.value.rows()) {
      case 1:
        add(std::integral_constant<int, 1>());
        break;
      case 2:
        add(std::integral_constant<int, 2>());
        break;
      default:
        add(std::integral_constant<int, kTriplet>());
    }
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

  const ColumnsOfH H(z, weight);
  MatrixXd columns;  // of P
  P.gather(H.shared_starts(), columns);
  out.PHt = multiply(columns, transposed(H.shared()));
  H.for_each_own([&](Index start, std::span<const Block> blocks) {
    P.gather(std::array<Index, 1>{start}, columns);
    add_products(columns.leftCols<kTriplet>(), blocks, out.PHt);
  });

  // S = (P Hᵀ)ᵀ Hᵀ + I, from the few rows of P Hᵀ that H touches.
  MatrixXd rows(m, H.shared().cols());
  for (std::size_t k = 0; k < H.shared_starts().size(); ++k) {
    rows.middleCols<kTriplet>(kTriplet * static_cast<Index>(k)) =
        out.PHt.middleRows<kTriplet>(H.shared_starts()[k]).transpose();
  }
  out.S = multiply(rows, transposed(H.shared()));
  out.S.diagonal().array() += 1.0;
  Eigen::Matrix<double, Eigen::Dynamic, kTriplet> row(m, kTriplet);
  H.for_each_own([&](Index start, std::span<const Block> blocks) {
    row = out.PHt.middleRows<kTriplet>(start).transpose();
    add_products(row, blocks, out.S);
  });
  return out;
}

}  // namespace limber
