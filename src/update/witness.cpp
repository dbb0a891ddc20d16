// SPDX-License-Identifier: MIT
#include "limber/update/witness.hpp"

#include <Eigen/Cholesky>
#include <array>

#include "limber/core/divergence_error.hpp"

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
  C.noalias() += columns * F.transpose();
  const MatrixXd F_W = F * rows.W.middleRows<kWitnessSize>(at);
  MatrixXd S = F * columns.middleRows<kWitnessSize>(at) * F.transpose() + F_W + F_W.transpose();
  S.diagonal().array() += 1.0;
  const Eigen::LLT<MatrixXd> llt(0.5 * (S + S.transpose()));
  if (llt.info() != Eigen::Success) {
    throw DivergenceError("witness: the covariance of its innovation is not positive definite");
  }
  const MatrixXd K = llt.solve(C.middleRows<kWitnessSize>(at).transpose()).transpose();
  columns.noalias() -= C * K.transpose();
  const MatrixXd own = columns.middleRows<kWitnessSize>(at);
  columns.middleRows<kWitnessSize>(at) = 0.5 * (own + own.transpose());
  P.scatter(block, columns);
  return K * (rows.y - F * mean);
}

}  // namespace limber
