// SPDX-License-Identifier: MIT
// What an update says of the parameters it watches when others are constrained as well.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "check_covariance.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/update.hpp"
#include "stereo_problem.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::StereoProblem;

constexpr Index kNuisance = 2;

StereoProblem nuisance_problem(Generator& generator, int points) {
  return testing::make_problem(generator, "nuisance", testing::stereo_rig(0.12),
                               testing::random_points(generator, points, 1.0, 20.0));
}

/// The first columns of C are watched, the last are nuisance.
ParameterErrorModel watch_first(const StereoProblem& problem) {
  ParameterErrorModel how;
  how.constrained = problem.C;
  how.watched = problem.C.leftCols(problem.C.cols() - kNuisance);
  how.nuisance = kNuisance;
  return how;
}

UpdateReport updated(const StereoProblem& problem, const ParameterErrorModel& how, bool compress,
                     Covariance& P) {
  return compress ? update(P, problem.z, how) : update(P, form_innovation(P, problem.z), how);
}

/// Evidence about the first parameters if the last are anything: the Schur complement.
ParameterEvidence marginal(const ParameterEvidence& all, Index kept) {
  const Index rest = all.vector.size() - kept;
  const Eigen::LLT<MatrixXd> M(all.information.bottomRightCorner(rest, rest));
  const MatrixXd mixed = all.information.topRightCorner(kept, rest);
  return {all.information.topLeftCorner(kept, kept) - mixed * M.solve(mixed.transpose()),
          all.vector.head(kept) - mixed * M.solve(all.vector.tail(rest))};
}

/// Largest entry of A − B, relative to the largest of B.
double relative_difference(const MatrixXd& A, const MatrixXd& B) {
  return (A - B).cwiseAbs().maxCoeff() / B.cwiseAbs().maxCoeff();
}

void expect_same(const ParameterEvidence& found, const ParameterEvidence& expected) {
  ASSERT_EQ(found.vector.size(), expected.vector.size());
  EXPECT_LE(relative_difference(found.information, expected.information), 1e-7);
  EXPECT_LE(relative_difference(found.vector, expected.vector), 1e-7);
}

TEST(Nuisance, ChangesNothingButWhatIsSaid) {
  Generator generator(1);
  for (const bool compress : {false, true}) {
    const StereoProblem problem = nuisance_problem(generator, 12);
    ParameterErrorModel all = watch_first(problem);
    all.watched = problem.C;
    all.nuisance = 0;
    Covariance P = problem.P, P_all = problem.P;
    const UpdateReport report = updated(problem, watch_first(problem), compress, P);
    const UpdateReport expected = updated(problem, all, compress, P_all);
    EXPECT_EQ(P.dense(), P_all.dense());
    EXPECT_EQ(report.dx, expected.dx);
    EXPECT_EQ(report.rank, expected.rank);
    expect_same(report.evidence, marginal(expected.evidence, problem.C.cols() - kNuisance));
  }
}

TEST(Nuisance, AloneLeavesTheEvidenceAboutWhatIsTrusted) {
  Generator generator(2);
  for (const int points : {6, 12, 30}) {
    for (const bool compress : {false, true}) {
      SCOPED_TRACE(::testing::Message() << points << " points, " << (compress ? "compressed" : "as it is"));
      const StereoProblem problem = nuisance_problem(generator, points);
      ParameterErrorModel how = watch_first(problem);
      how.constrained = problem.C.rightCols(kNuisance).eval();
      ParameterErrorModel plain;
      plain.watched = problem.C;
      Covariance P = problem.P, P_plain = problem.P;
      const UpdateReport report = updated(problem, how, compress, P);
      const UpdateReport all = updated(problem, plain, compress, P_plain);
      expect_same(report.evidence, marginal(all.evidence, problem.C.cols() - kNuisance));
      // What is watched is trusted: the gain is that of the constraint alone.
      ParameterErrorModel unwatched;
      unwatched.constrained = how.constrained;
      Covariance P_unwatched = problem.P;
      const UpdateReport same = updated(problem, unwatched, compress, P_unwatched);
      EXPECT_LE(relative_difference(report.dx, same.dx), 1e-9);
      EXPECT_LE(testing::relative_difference(P.dense(), P_unwatched.dense(), testing::prior_sigma(problem.P)),
                1e-9);
    }
  }
}

/// The witness's gain is the optimal one if the nuisance is a huge white error of every frame.
TEST(Nuisance, IsNothingThatTheWitnessLearnsFrom) {
  Generator generator(3);
  for (const bool compress : {false, true}) {
    StereoProblem problem = nuisance_problem(generator, 15);
    const Index n = problem.P.size();
    VectorXd sigma(n + kWitnessSize);
    sigma << testing::prior_sigma(problem.P), VectorXd::Constant(kWitnessSize, 2.0);
    problem.P.append(kWitnessSize);
    problem.P.set_diagonal_block(0, testing::random_covariance(generator, sigma));
    ParameterErrorModel how = watch_first(problem);
    how.witness = Witness{n, testing::random_normal(generator, kWitnessSize)};
    const MatrixXd prior = problem.P.dense(), R = problem.R();
    const MatrixXd DB = multiply(problem.z.D, how.watched), DX = problem.z.D * problem.C.rightCols(kNuisance);
    MatrixXd H = problem.H();
    H.middleCols(n, DB.cols()) += DB;
    const MatrixXd S = congruence(H, prior) + R + 1e8 * multiply(DX, transposed(DX));
    const MatrixXd K = Cholesky(S).solve(multiply(H, prior.middleCols(n, kWitnessSize))).transpose();
    const VectorXd expected = K * (problem.z.residual - DB * how.witness->mean.head(DB.cols()));

    Covariance P = problem.P;
    const UpdateReport report = updated(problem, how, compress, P);
    EXPECT_LE(relative_difference(report.dx.segment(n, kWitnessSize), expected), 1e-4);
    const MatrixXd own =
        prior.block(n, n, kWitnessSize, kWitnessSize) - K * H * prior.middleCols(n, kWitnessSize);
    EXPECT_LE(relative_difference(P.dense().block(n, n, kWitnessSize, kWitnessSize), own), 1e-4);
  }
}

TEST(Nuisance, MoreColumnsThanThereAreIsAnError) {
  Generator generator(4);
  const StereoProblem problem = nuisance_problem(generator, 8);
  ParameterErrorModel how = watch_first(problem);
  how.nuisance = problem.C.cols() + 1;
  Covariance P = problem.P;
  EXPECT_THROW((void)update(P, problem.z, how), std::invalid_argument);
  how.nuisance = kNuisance + 1;  // then one column is neither watched nor nuisance
  EXPECT_THROW((void)update(P, problem.z, how), std::invalid_argument);
}

}  // namespace
}  // namespace limber
