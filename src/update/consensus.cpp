// SPDX-License-Identifier: MIT
#include "limber/update/consensus.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/factors.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int kIterations = 30;           // by least sum of distances: finds the majority from anywhere
constexpr int kConsensusRefinements = 5;  // with weights that fall with the square: forgets the minority
constexpr double kClose = 2.5;            // standard deviations: nearer groups count alike

}  // namespace

Consensus find_consensus(const WhiteGroups& white, double scale) {
  const VectorXd& y = white.r;
  const MatrixXd F = scale * white.A;
  const std::vector<RowGroup>& groups = white.groups;
  Consensus out{VectorXd::Zero(F.cols()), std::vector<double>(groups.size())};
  VectorXd e = y, weight = VectorXd::Ones(y.size());
  bool settled = false;
  for (int i = 0, refinements = 0; refinements < kConsensusRefinements && F.cols() > 0; ++i) {
    settled = settled || i >= kIterations;
    refinements += settled ? 1 : 0;
    for (const RowGroup& group : groups) {
      const double w = kClose / std::max(e.segment(group.row, group.rows).norm(), kClose);
      weight.segment(group.row, group.rows).setConstant(settled ? w * w : w);
    }
    const MatrixXd WF = weight.asDiagonal() * F;
    MatrixXd M = multiply(transposed(F), WF);
    M.diagonal().array() += 1.0;  // the prior
    const VectorXd before = out.beta;
    out.beta = Cholesky(M).solve(WF.transpose() * y);
    e = y - F * out.beta;
    settled = settled || (out.beta - before).squaredNorm() < 1e-6 * (1.0 + out.beta.squaredNorm());
  }
  for (std::size_t g = 0; g < groups.size(); ++g) {
    out.distance[g] = e.segment(groups[g].row, groups[g].rows).squaredNorm();
  }
  return out;
}

}  // namespace limber
