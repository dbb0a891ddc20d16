// SPDX-License-Identifier: MIT
#include "limber/update/witness.hpp"

#include <array>

#include "limber/core/divergence_error.hpp"
#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd learn(Covariance& P, Index at, const Eigen::Ref<const VectorXd>& mean, const UnusedRows& rows) {
  MatrixXd F = MatrixXd::Zero(rows.F.rows(), kWitnessSize);
  F.leftCols(rows.F.cols()) = rows.F;
  const std::array<Index, 2> block = {at, at + kTriplet};
  MatrixXd columns;  // of P: n × kWitnessSize
  P.gather(block, columns);
  // Covariances with the innovation e = y − F mean = F (beta − mean) + eps.
  MatrixXd C = rows.W;
  add_product(C, 1.0, columns, transposed(F));
  const MatrixXd F_W = multiply(F, rows.W.middleRows<kWitnessSize>(at));
  MatrixXd S = congruence(F, columns.middleRows<kWitnessSize>(at)) + F_W + F_W.transpose();
  S.diagonal().array() += 1.0;
  const Cholesky llt(symmetric_part(S));
  if (!llt.succeeded()) {
    throw DivergenceError("witness: the covariance of its innovation is not positive definite");
  }
  const MatrixXd K = llt.solve(C.middleRows<kWitnessSize>(at).transpose()).transpose();
  add_product(columns, -1.0, C, transposed(K));
  const MatrixXd own = columns.middleRows<kWitnessSize>(at);
  columns.middleRows<kWitnessSize>(at) = symmetric_part(own);
  P.scatter(block, columns);
  return K * (rows.y - F * mean);
}

}  // namespace limber
