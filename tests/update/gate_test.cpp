// SPDX-License-Identifier: MIT
#include "limber/update/gate.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <set>

#include "check_covariance.hpp"
#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/consensus.hpp"
#include "limber/update/constraint.hpp"
#include "limber/update/frame_innovation.hpp"
#include "random_frame.hpp"
#include "stereo_problem.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::draw_residual;
using testing::Generator;
using testing::random_frame;
using testing::StereoProblem;

constexpr double kProbability = 0.999;

GateReport gated(const StereoProblem& problem, const ParameterErrorModel& model,
                 double probability = kProbability) {
  const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
  return gate(frame.innovation, frame.groups, model, GateThresholds(probability));
}

/// Row for row, nothing turned.
GateReport gated_as_it_is(const StereoProblem& problem, const ParameterErrorModel& model) {
  return gate(form_innovation(problem.P, problem.z), problem.z.groups, model, GateThresholds(kProbability));
}

std::set<std::size_t> refused(const GateReport& report) {
  std::set<std::size_t> out;
  for (std::size_t g = 0; g < report.accepted.size(); ++g) {
    if (!report.accepted[g]) {
      out.insert(g);
    }
  }
  return out;
}

/// Two degrees and 20 % of the baseline in every parameter.
VectorXd huge_error(const StereoProblem& problem) {
  const VectorXd signs = (VectorXd(6) << 1.0, -1.0, 1.0, 1.0, -1.0, 1.0).finished();
  const VectorXd times = (VectorXd(6) << 20.0, 20.0, 20.0, 4.0, 4.0, 4.0).finished();
  return problem.C * signs.cwiseProduct(times);
}

/// The slow and obvious elimination: after each drop everything anew, dense, on the projected residual
/// itself.
/// @return whether no more than `most` groups had to go
bool obvious_elimination(const StereoProblem& problem, const ParameterErrorModel& model, std::size_t most,
                         GateReport& report) {
  const MatrixXd P = problem.P.dense();
  for (std::size_t dropped = 0;; ++dropped) {
    const LinearMeasurement z = problem.z.subset(report.accepted);
    const MatrixXd W = z.sigma.cwiseInverse().asDiagonal();
    const MatrixXd H = W * z.H.dense(z.rows(), P.rows());
    MatrixXd S = congruence(H, P) + MatrixXd::Identity(z.rows(), z.rows());
    if (model.white_covariance.size() > 0) {
      S += W * congruence(z.D, model.white_covariance) * W;
    }
    // r − D dtheta_hat and its covariance, by the oblique projector onto what D C cannot explain.
    MatrixXd M = MatrixXd::Identity(z.rows(), z.rows());
    if (model.constrained.cols() > 0) {
      const MatrixXd A = strong_directions(W * z.D * model.constrained);
      const MatrixXd SinvA = Cholesky(S).solve(A);
      add_product(M, -1.0, A, Cholesky(multiply(transposed(A), SinvA)).solve(SinvA.transpose()));
    }
    const VectorXd e = M * (W * z.residual);
    const MatrixXd B = congruence(M, S);
    double worst_ratio = 1.0;
    std::size_t worst = problem.z.groups.size();
    std::size_t kept = 0;
    for (std::size_t g = 0; g < report.accepted.size(); ++g) {
      if (!report.accepted[g]) {
        continue;
      }
      const auto [row, rows, own, fourth] = z.groups[kept++];
      // In units of the group's own S, or a new landmark's huge variance makes a direction look used up.
      const Cholesky root(S.block(row, row, rows, rows));
      MatrixXd white = B.block(row, row, rows, rows);
      solve_lower(root.factor(), white);
      solve_lower_from_right(transposed(root.factor()), white);
      VectorXd white_e = e.segment(row, rows);
      solve_lower(root.factor(), white_e);
      Eigen::CompleteOrthogonalDecomposition<MatrixXd> block;
      block.setThreshold(1e-8);
      block.compute(white);
      report.distance[g] = white_e.dot(block.solve(white_e));
      report.threshold[g] = chi_square_quantile(kProbability, static_cast<double>(block.rank()));
      if (report.distance[g] > worst_ratio * report.threshold[g]) {
        worst_ratio = report.distance[g] / report.threshold[g];
        worst = g;
      }
    }
    if (worst == report.accepted.size()) {
      return true;
    }
    if (dropped == most) {
      return false;
    }
    report.accepted[worst] = false;
  }
}

/// The groups that lie far from what most agree upon; none if these are more than half (two thirds of what is
/// constrained).
std::vector<bool> obvious_gross(const StereoProblem& problem, const ParameterErrorModel& model) {
  const Innovation innovation = form_innovation(problem.P, problem.z);
  MatrixXd S = innovation.S;
  MatrixXd A(S.rows(), 0);
  if (model.white_covariance.size() > 0) {
    S += congruence(innovation.D, model.white_covariance);
  }
  if (model.constrained.cols() > 0) {
    A = innovation.D * model.constrained;
  }
  const Consensus consensus = find_consensus(white_groups(innovation.r, S, A, problem.z.groups), 10.0);
  std::vector<bool> gross(problem.z.groups.size());
  for (std::size_t g = 0; g < gross.size(); ++g) {
    gross[g] =
        consensus.distance[g] >
        kGrossOutlier * chi_square_quantile(kProbability, static_cast<double>(problem.z.groups[g].rows));
  }
  const auto count = static_cast<std::size_t>(std::count(gross.begin(), gross.end(), true));
  if (model.constrained.cols() > 0 ? 3 * count > 2 * gross.size() : 2 * count > gross.size()) {
    gross.assign(gross.size(), false);
  }
  return gross;
}

GateReport obvious_gate(const StereoProblem& problem, const ParameterErrorModel& model) {
  const std::size_t n = problem.z.groups.size();
  GateReport report{std::vector<bool>(n, true), std::vector<double>(n, 0.0), std::vector<double>(n, 0.0),
                    std::vector<Index>(n, 0)};
  GateReport first = report;
  if (obvious_elimination(problem, model, 0, first)) {
    return first;  // none fails
  }
  std::vector<bool> kept = obvious_gross(problem, model);
  kept.flip();
  report.accepted = kept;
  const auto gross = static_cast<std::size_t>(std::count(kept.begin(), kept.end(), false));
  const std::size_t most = gross <= n / 2 ? n / 2 - gross : (n - gross) / 4;
  if (!obvious_elimination(problem, model, most, report)) {
    report.accepted = kept;
    report.overruled = true;
  }
  return report;
}

TEST(Gate, RefusesNoPointForAPureCalibrationError) {
  Generator generator(1);
  for (int k = 0; k < 20; ++k) {
    StereoProblem problem = random_frame(generator);
    problem.z.residual =
        problem.z.D * huge_error(problem) +
        0.3 * problem.z.sigma.cwiseProduct(testing::random_normal(generator, problem.z.rows()));
    EXPECT_TRUE(gated(problem, problem.constrained()).all_accepted());
    EXPECT_TRUE(gated(problem, {}).overruled) << "the error is too small to test anything";
  }
}

TEST(Gate, DropsExactlyThePlantedOutliersUnderAHugeCalibrationError) {
  Generator generator(2);
  for (int k = 0; k < 20; ++k) {
    StereoProblem problem = random_frame(generator, 30);
    problem.z.residual =
        problem.z.D * huge_error(problem) +
        0.3 * problem.z.sigma.cwiseProduct(testing::random_normal(generator, problem.z.rows()));
    const std::set<std::size_t> planted = {3, 8, static_cast<std::size_t>(10 + k % 5)};
    for (const std::size_t g : planted) {
      const RowGroup& group = problem.z.groups[g];
      problem.z.residual.segment(group.row, group.rows) +=
          300.0 * testing::random_direction(generator).x() * VectorXd::Ones(group.rows) +
          VectorXd::Constant(group.rows, 500.0);
    }
    EXPECT_EQ(refused(gated(problem, problem.constrained())), planted);
  }
}

TEST(Gate, AgreesWithTheSlowObviousOne) {
  Generator generator(3);
  int dropped = 0;
  for (int k = 0; k < 120; ++k) {
    StereoProblem problem = random_frame(generator, 2 + k % 20);
    if (k % 4 == 3) {
      testing::make_theta_a_state(problem);
    }
    draw_residual(generator, problem);
    problem.z.residual += problem.z.D * huge_error(problem);
    for (int outlier = 0; outlier < k % 5 && 7 * outlier < problem.z.rows(); ++outlier) {
      problem.z.residual(7 * outlier) += 40.0;
    }
    ParameterErrorModel model;
    if (k % 3 != 0) {
      model.constrained = k % 3 == 1 ? problem.C : MatrixXd(problem.C.leftCols<3>());
    }
    if (k % 2 == 0) {
      model.white_covariance = multiply(problem.C, transposed(problem.C));
    }
    const GateReport expected = obvious_gate(problem, model);
    const std::vector<bool> gross = obvious_gross(problem, model);
    for (const GateReport& found : {gated(problem, model), gated_as_it_is(problem, model)}) {
      EXPECT_EQ(found.accepted, expected.accepted) << k;
      EXPECT_EQ(found.overruled, expected.overruled) << k;
      for (std::size_t g = 0; g < found.accepted.size(); ++g) {
        if (!gross[g] || found.accepted[g]) {  // a gross outlier's is that from the consensus
          EXPECT_NEAR(found.distance[g], expected.distance[g], 1e-6 * (1.0 + expected.distance[g])) << k;
          EXPECT_NEAR(found.threshold[g], expected.threshold[g], 1e-9) << k;
        }
      }
    }
    dropped += static_cast<int>(refused(expected).size());
  }
  EXPECT_GE(dropped, 60);
}

/// With the rig off by a lot, a quarter of the points mismatched: as one outlier spoils the offset that is
/// projected out for all others, dropping the worst in turn refused good points here, and overruled itself.
/// Where that still happens, in one or two frames of twenty, it is the limit of the method: docs/faults.md.
TEST(Gate, RefusesAQuarterOfGrossMismatchesUnderAHugeCalibrationErrorInNineFramesOfTen) {
  Generator generator(12);
  int clean_frames = 0;
  for (int k = 0; k < 20; ++k) {
    StereoProblem problem = random_frame(generator, 45);
    draw_residual(generator, problem);
    problem.z.residual += problem.z.D * huge_error(problem);
    std::set<std::size_t> planted;
    for (std::size_t g = static_cast<std::size_t>(k % 4); g < problem.z.groups.size(); g += 4) {
      const RowGroup& group = problem.z.groups[g];
      // The pixels of the last camera that saw it, as a mismatch has it.
      const Eigen::Vector2d direction = testing::random_direction(generator).head<2>();
      problem.z.residual.segment<2>(group.row + group.rows - 2) += 150.0 * direction.normalized();
      planted.insert(g);
    }
    const GateReport report = gated(problem, problem.constrained());
    std::size_t found = 0, good = 0;
    for (const std::size_t g : refused(report)) {
      (planted.contains(g) ? found : good) += 1;
    }
    clean_frames += !report.overruled && found + 1 >= planted.size() && good <= 2U ? 1 : 0;
  }
  EXPECT_GE(clean_frames, 18);
}

TEST(Gate, AfterItTheRestIsJudgedAsIfTheDroppedHadNeverBeenThere) {
  Generator generator(4);
  StereoProblem problem = random_frame(generator);
  draw_residual(generator, problem);
  problem.z.residual.segment<2>(problem.z.groups[5].row).setConstant(1000.0);
  const GateReport first = gated(problem, problem.constrained());
  ASSERT_TRUE(refused(first).contains(5));
  StereoProblem rest = problem;
  rest.z = problem.z.subset(first.accepted);
  const GateReport second = gated(rest, problem.constrained());
  EXPECT_TRUE(second.all_accepted());
  std::size_t kept = 0;
  for (std::size_t g = 0; g < first.accepted.size(); ++g) {
    if (first.accepted[g]) {
      EXPECT_NEAR(first.distance[g], second.distance[kept++], 1e-6) << g;
    }
  }
}

TEST(Gate, WithoutConstraintJudgesEachGroupByItsOwnBlock) {
  Generator generator(5);
  StereoProblem problem = random_frame(generator);
  draw_residual(generator, problem);
  const GateReport report = gated(problem, {});
  const MatrixXd S = congruence(problem.H(), problem.P.dense()) + problem.R();
  for (std::size_t g = 0; g < problem.z.groups.size(); ++g) {
    const auto [row, rows, own, fourth] = problem.z.groups[g];
    const VectorXd r = problem.z.residual.segment(row, rows);
    const double expected = r.dot(Cholesky(S.block(row, row, rows, rows)).solve(r));
    EXPECT_NEAR(report.distance[g], expected, 1e-9 * (1.0 + expected));
    EXPECT_NEAR(report.threshold[g], chi_square_quantile(kProbability, static_cast<double>(rows)), 1e-12);
  }
}

TEST(Gate, RefusesNothingOfAGroupThatTheConstraintsUseUp) {
  Generator generator(6);
  // One stereo point among left-only ones: its right rows are explained by the constraints, whatever they
  // say; its left rows are judged.
  std::vector<testing::SeenPoint> points = testing::random_points(generator, 4, 5.0, 10.0);
  for (std::size_t k = 1; k < points.size(); ++k) {
    points[k].in_cam1 = false;
  }
  StereoProblem problem = testing::make_problem(generator, "", testing::stereo_rig(0.5), points);
  problem.z.residual.setConstant(0.1);
  problem.z.residual.segment<2>(2) << 1e4, -1e4;
  const GateReport right = gated(problem, problem.constrained());
  EXPECT_TRUE(right.all_accepted());
  problem.z.residual.setConstant(0.1);
  problem.z.residual.head<2>() << 1e4, -1e4;
  const GateReport left = gated(problem, problem.constrained());
  EXPECT_EQ(refused(left), std::set<std::size_t>{0});
}

TEST(Gate, WhereMostWouldFailItBlamesTheModelAndRefusesNone) {
  Generator generator(9);
  StereoProblem problem = random_frame(generator, 20);
  for (const int count : {9, 12, 20}) {
    problem.z.residual = 0.3 * problem.z.sigma;
    for (int g = 0; g < count; ++g) {
      const RowGroup& group = problem.z.groups[static_cast<std::size_t>(g)];
      problem.z.residual.segment(group.row, group.rows) =
          2000.0 * testing::random_normal(generator, group.rows);
    }
    const GateReport report = gated(problem, {});
    EXPECT_EQ(report.overruled, count > 10) << count;
    EXPECT_EQ(report.all_accepted(), count > 10) << count;
  }
}

TEST(Gate, TellsThatNothingIsThereToJudge) {
  Innovation innovation;
  innovation.r.resize(0);
  innovation.D.resize(0, 6);
  innovation.PHt.resize(15, 0);
  innovation.S.resize(0, 0);
  const GateReport report = gate(innovation, {}, {}, GateThresholds(kProbability));
  EXPECT_TRUE(report.all_accepted());
  EXPECT_TRUE(report.distance.empty());
}

/// Each good group is refused with probability 1 − p at least in the first judgement. Runs are independent,
/// groups within a run are not: the bound is on the number of runs in which one fixed group is refused, five
/// standard deviations of the binomial (one in a million), and on the expected direction: no more than that.
TEST(Gate, RefusesGoodPointsAsOftenAsItIsTold) {
  constexpr int kRuns = 4000;
  constexpr double kPass = 0.95;
  Generator generator(7);
  StereoProblem problem = random_frame(generator, 10);
  for (const bool constrained : {false, true}) {
    const ParameterErrorModel model = constrained ? problem.constrained() : ParameterErrorModel{};
    std::vector<int> exceeded(problem.z.groups.size(), 0);
    for (int run = 0; run < kRuns; ++run) {
      draw_residual(generator, problem);
      if (constrained) {
        problem.z.residual += problem.z.D * huge_error(problem);
      }
      // A gate that drops nothing tells the distances of the first judgement.
      const GateReport report = gated(problem, model, 1.0 - 1e-15);
      for (std::size_t g = 0; g < exceeded.size(); ++g) {
        const auto dof = static_cast<double>(problem.z.groups[g].rows);
        exceeded[g] += report.distance[g] > chi_square_quantile(kPass, dof) ? 1 : 0;
      }
    }
    const double mean = (1.0 - kPass) * kRuns;
    const double band = 5.0 * std::sqrt(kPass * mean);
    for (std::size_t g = 0; g < exceeded.size(); ++g) {
      EXPECT_NEAR(exceeded[g], mean, band) << "group " << g << (constrained ? ", constrained" : ", plain");
    }
  }
}

}  // namespace
}  // namespace limber
