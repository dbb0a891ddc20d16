// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/QR>

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
using testing::relative_difference;
using testing::StereoProblem;

/// The problem with six more states, correlated with all others, that H does not look at.
struct WitnessProblem {
  StereoProblem stereo;
  Witness witness;
};

WitnessProblem witness_problem(Generator& generator, int points) {
  WitnessProblem out{testing::make_problem(generator, "witness", testing::stereo_rig(0.12),
                                           testing::random_points(generator, points, 1.0, 20.0)),
                     {}};
  const Index n = out.stereo.P.size();
  VectorXd sigma(n + kWitnessSize);
  sigma << testing::prior_sigma(out.stereo.P), VectorXd::Constant(kWitnessSize, 2.0);
  out.stereo.P.append(kWitnessSize);
  out.stereo.P.set_diagonal_block(0, testing::random_covariance(generator, sigma));
  out.witness.at = n;
  out.witness.mean = testing::random_normal(generator, kWitnessSize);
  return out;
}

ParameterErrorModel model(const WitnessProblem& problem) {
  ParameterErrorModel how;
  how.constrained = how.watched = problem.stereo.C;
  how.witness = problem.witness;
  return how;
}

/// The joint filter written out: states with the constrained gain, the witness with the optimal one, and
/// Joseph's form, which holds for any gain.
struct Joint {
  VectorXd dx;
  MatrixXd P;
};

Joint joseph(const WitnessProblem& problem) {
  const MatrixXd P = problem.stereo.P.dense();
  const Index n = P.rows(), at = problem.witness.at;
  const MatrixXd H_states = problem.stereo.H(), R = problem.stereo.R();
  const MatrixXd DC = multiply(problem.stereo.z.D, problem.stereo.C);
  MatrixXd H = H_states;
  H.middleCols(at, kWitnessSize) = DC;
  const MatrixXd Q = householder_qr(DC).Q();
  const MatrixXd N = Q.rightCols(Q.cols() - DC.cols());
  const MatrixXd S_rest = congruence(transposed(N), congruence(H_states, P) + R);
  MatrixXd G =
      multiply(multiply(multiply(P, transposed(H_states)), N), Cholesky(S_rest).solve(N.transpose()));
  const MatrixXd S = congruence(H, P) + R;
  G.middleRows(at, kWitnessSize) = Cholesky(S).solve(multiply(H, P.middleCols(at, kWitnessSize))).transpose();
  const MatrixXd A = MatrixXd::Identity(n, n) - multiply(G, H);
  Joint out{G * (problem.stereo.z.residual - DC * problem.witness.mean), congruence(A, P)};
  out.P += congruence(G, R);
  return out;
}

TEST(Witness, IsTheOptimalGainBesideTheConstrainedOne) {
  Generator generator(1);
  for (const int points : {5, 8, 20}) {
    for (const bool compress : {false, true}) {
      const WitnessProblem problem = witness_problem(generator, points);
      const Joint expected = joseph(problem);
      Covariance P = problem.stereo.P;
      const UpdateReport report = compress ? update(P, problem.stereo.z, model(problem))
                                           : update(P, form_innovation(P, problem.stereo.z), model(problem));
      const VectorXd sigma = testing::prior_sigma(problem.stereo.P);
      ASSERT_EQ(report.status, UpdateStatus::kUpdated);
      EXPECT_LE(relative_difference(report.dx, expected.dx, sigma), 1e-8) << points;
      EXPECT_LE(relative_difference(P.dense(), expected.P, sigma), 1e-9) << points;
    }
  }
}

TEST(Witness, NoOtherStateHearsOfIt) {
  Generator generator(2);
  const WitnessProblem problem = witness_problem(generator, 12);
  ParameterErrorModel without = model(problem);
  without.watched.resize(6, 0);
  without.witness.reset();
  Covariance P_with = problem.stereo.P, P_without = problem.stereo.P;
  const UpdateReport with = update(P_with, problem.stereo.z, model(problem));
  const UpdateReport alone = update(P_without, problem.stereo.z, without);
  const Index n = problem.witness.at;
  const VectorXd sigma = testing::prior_sigma(problem.stereo.P).head(n);
  EXPECT_LE(relative_difference(VectorXd(with.dx.head(n)), VectorXd(alone.dx.head(n)), sigma), 1e-10);
  EXPECT_LE(relative_difference(MatrixXd(P_with.dense().topLeftCorner(n, n)),
                                MatrixXd(P_without.dense().topLeftCorner(n, n)), sigma),
            1e-12);
  EXPECT_NEAR(with.nis, alone.nis, 1e-9 * alone.nis);
  EXPECT_EQ(with.dof, alone.dof);
}

TEST(ParameterEvidence, IsThatOfTheInnovation) {
  Generator generator(3);
  for (const bool constrained : {false, true}) {
    const StereoProblem problem = testing::make_problem(generator, "evidence", testing::stereo_rig(2.0),
                                                        testing::random_points(generator, 15, 2.0, 60.0));
    const MatrixXd S = congruence(problem.H(), problem.P.dense()) + problem.R();
    const MatrixXd DC = multiply(problem.z.D, problem.C);
    const MatrixXd information = multiply(transposed(DC), Cholesky(S).solve(DC));
    const VectorXd vector = DC.transpose() * Cholesky(S).solve(problem.z.residual);
    ParameterErrorModel how;
    how.watched = problem.C;
    if (constrained) {
      how.constrained = problem.C;
    }
    Covariance P = problem.P;
    const ParameterEvidence evidence = update(P, problem.z, how).evidence;
    EXPECT_LE((evidence.information - information).norm(), 1e-8 * information.norm());
    EXPECT_LE((evidence.vector - vector).norm(), 1e-8 * vector.norm());
    const EvidenceStatistic s = statistic(evidence, 1e-12);
    EXPECT_EQ(s.dof, 6);
    EXPECT_NEAR(s.value, vector.dot(solve_symmetric(information, vector)), 1e-6 * s.value);
  }
}

TEST(ParameterEvidence, AWhiteShareCanBeTakenOutAgain) {
  Generator generator(4);
  const StereoProblem problem = testing::make_problem(generator, "white", testing::stereo_rig(0.12),
                                                      testing::random_points(generator, 15, 2.0, 20.0));
  ParameterErrorModel plain;
  plain.watched = problem.C;
  ParameterErrorModel soft = plain;
  soft.white_covariance = multiply(problem.C, transposed(problem.C));
  Covariance P_plain = problem.P, P_soft = problem.P;
  const ParameterEvidence expected = update(P_plain, problem.z, plain).evidence;
  const ParameterEvidence with_share = update(P_soft, problem.z, soft).evidence;
  EXPECT_GT((with_share.information - expected.information).norm(), 0.1 * expected.information.norm());
  const ParameterEvidence evidence = without_white(with_share, MatrixXd::Identity(6, 6));
  EXPECT_LE((evidence.information - expected.information).norm(), 1e-8 * expected.information.norm());
  EXPECT_LE((evidence.vector - expected.vector).norm(), 1e-8 * expected.vector.norm());
}

TEST(ParameterEvidence, DirectionsThatAreNotSeenDoNotCount) {
  ParameterEvidence evidence{MatrixXd::Zero(6, 6), VectorXd::Zero(6)};
  evidence.information.diagonal() << 4.0, 1.0, 0.0, 1e-6, 9.0, 0.0;
  evidence.vector << 2.0, 1.0, 0.0, 1.0, 3.0, 0.0;
  const EvidenceStatistic s = statistic(evidence, 1e-2);
  EXPECT_EQ(s.dof, 3);
  EXPECT_NEAR(s.value, 3.0, 1e-12);
  EXPECT_EQ(statistic({}, 1.0).dof, 0);
}

}  // namespace
}  // namespace limber
