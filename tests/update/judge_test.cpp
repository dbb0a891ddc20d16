// SPDX-License-Identifier: MIT
#include "update/judge.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "random_frame.hpp"

namespace limber::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::StereoProblem;

struct Off {
  double distance = 0.0, away = 0.0;
};

/// eᵀB⁺e and |B⁺e|², dense, of a group beside what all say of the parameters.
/// @param prior  information on each parameter
Off off(const Judged& judged, const RowGroup& group, double prior) {
  const MatrixXd Sinv = judged.S.inverse();
  MatrixXd M = judged.DC.transpose() * Sinv * judged.DC;
  M.diagonal().array() += prior;
  const MatrixXd covariance = Eigen::CompleteOrthogonalDecomposition<MatrixXd>(M).pseudoInverse();
  const VectorXd delta = covariance * judged.DC.transpose() * Sinv * judged.r;
  const MatrixXd root = judged.S.block(group.row, group.row, group.rows, group.rows).llt().matrixL();
  const MatrixXd A = root.inverse() * judged.DC.middleRows(group.row, group.rows);
  const VectorXd e = root.inverse() * judged.r.segment(group.row, group.rows) - A * delta;
  const MatrixXd B = MatrixXd::Identity(group.rows, group.rows) - A * covariance * A.transpose();
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> inverse;
  inverse.setThreshold(1e-8);
  inverse.compute(B);
  const VectorXd away = inverse.solve(e);
  return {e.dot(away), away.squaredNorm()};
}

/// Points of which the last is much nearer, its right pixel wrong: after a point is dropped, too.
TEST(Judge, MeasuresAsTheSlowObviousOne) {
  Generator generator(31);
  int asked = 0;
  for (int run = 0; run < 40; ++run) {
    std::vector<testing::SeenPoint> points = testing::random_points(generator, 12 + run % 10, 4.0, 30.0);
    points.push_back(testing::random_points(generator, 1, 0.3, 1.0).front());
    StereoProblem problem = testing::make_problem(generator, "", testing::stereo_rig(0.1), points);
    testing::draw_residual(generator, problem);
    problem.z.residual(problem.z.rows() - 1) += 5.0 * run;
    Judged judged =
        judged_rows(form_innovation(problem.P, problem.z), problem.z.groups, problem.constrained());
    judged.asks_others = run % 4 != 0;
    Judge judge(judged);
    GateReport report{std::vector<bool>(points.size(), true),
                      std::vector<double>(points.size()),
                      {},
                      std::vector<Index>(points.size())};
    if (run % 2 == 1) {
      judge.drop(judged.groups.front());
      report.accepted.front() = false;
    }
    judge.measure(report);
    const Judged rest = judged.subset(report.accepted);
    for (std::size_t g = 0, kept = 0; g < points.size(); ++g) {
      if (!report.accepted[g]) {
        continue;
      }
      const RowGroup& group = rest.groups[kept++];
      const Off beside = off(rest, group, 0.0), plausibly = off(rest, group, 1.0);
      const double others = judged.asks_others ? std::min(beside.away, plausibly.away) / 10.0 : 0.0;
      asked += others > beside.distance ? 1 : 0;
      EXPECT_NEAR(report.distance[g], std::max(beside.distance, others), 1e-5 * (1.0 + report.distance[g]))
          << run << ", " << g;
    }
  }
  EXPECT_GE(asked, 10);
}

}  // namespace
}  // namespace limber::detail
