// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "limber/update/frame_innovation.hpp"
#include "limber/update/gate.hpp"
#include "random_frame.hpp"

/// Where nothing but the images tell how the body moved.
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
constexpr std::size_t kWrong = 4;  // both cameras see it

/// A map that is known to a pixel or so, and a pose that may be a thousand times further off.
StereoProblem after_an_unknown_motion(Generator& generator) {
  StereoProblem problem = random_frame(generator, 30);
  MatrixXd P = problem.P.dense() / 1e4;
  P.topLeftCorner(6, 6) *= 1e6;
  problem.P.assign(P);
  draw_residual(generator, problem);
  return problem;
}

GateReport gated_beside_the_pose(const StereoProblem& problem, const ParameterErrorModel& model) {
  const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
  return gate(frame.innovation, frame.groups, model, GateThresholds(kProbability),
              {false, {}, problem.P.diagonal_block<6>(0), {}});
}

TEST(GatePose, RefusesAMismatchThatSomeMotionWouldExplain) {
  Generator generator(31);
  int seen = 0, seen_without = 0;
  for (int run = 0; run < 20; ++run) {
    StereoProblem problem = after_an_unknown_motion(generator);
    const RowGroup& group = problem.z.groups[kWrong];
    problem.z.residual.segment(group.row, group.rows).array() += 15.0;  // [px]
    for (const ParameterErrorModel& model : {ParameterErrorModel{}, problem.constrained()}) {
      const GateReport report = gated_beside_the_pose(problem, model);
      seen += report.accepted[kWrong] ? 0 : 1;
      EXPECT_LE(std::count(report.accepted.begin(), report.accepted.end(), false), 2) << run;
      const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
      seen_without +=
          gate(frame.innovation, frame.groups, model, GateThresholds(kProbability)).accepted[kWrong] ? 0 : 1;
    }
  }
  EXPECT_GE(seen, 38) << "of 40: a point's own position may explain it, too";
  EXPECT_LT(seen_without, 20) << "of 40: the mismatch is too large to test anything";
}

TEST(GatePose, RefusesSoundPointsAsRarelyAsIsAsked) {
  Generator generator(32);
  std::ptrdiff_t refused = 0;
  for (int run = 0; run < 100; ++run) {
    const StereoProblem problem = after_an_unknown_motion(generator);
    const GateReport report =
        gated_beside_the_pose(problem, run % 2 == 0 ? ParameterErrorModel{} : problem.constrained());
    refused += std::count(report.accepted.begin(), report.accepted.end(), false);
  }
  EXPECT_LE(refused, 11) << "of 3000 points, of which 3 are expected";  // Poisson: 2e-4 beyond
}

/// What only a bent rig explains is no mismatch; that it contradicts the rig as it is has to be said.
TEST(GatePose, OfAFilterThatTrustsTheRigRefusesNothingThatABentOneExplains) {
  Generator generator(34);
  for (int run = 0; run < 10; ++run) {
    StereoProblem problem = after_an_unknown_motion(generator);
    const VectorXd bent = 30.0 * problem.C * VectorXd::Ones(problem.C.cols());
    problem.z.residual += problem.z.D * bent;
    const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
    PredictedPose predicted{false, {}, problem.P.diagonal_block<6>(0), problem.C};
    const GateReport report =
        gate(frame.innovation, frame.groups, {}, GateThresholds(kProbability), predicted);
    EXPECT_LE(std::count(report.accepted.begin(), report.accepted.end(), false), 1) << run;
    EXPECT_TRUE(report.overruled) << run;
    predicted.rig.resize(0, 0);
    const GateReport trusting =
        gate(frame.innovation, frame.groups, {}, GateThresholds(kProbability), predicted);
    EXPECT_TRUE(trusting.overruled) << run;
  }
}

/// Distances are those beside a pose that is constrained, and takes the map along as far as they are
/// correlated.
TEST(GatePose, AgreesWithAConstraintThatThePoseIsPartOf) {
  Generator generator(33);
  for (int run = 0; run < 20; ++run) {
    StereoProblem problem = after_an_unknown_motion(generator);
    const Innovation innovation = form_innovation(problem.P, problem.z);
    const GateReport fast =
        gate(innovation, problem.z.groups, problem.constrained(), GateThresholds(kProbability),
             {false, {}, problem.P.diagonal_block<6>(0), {}});
    const VectorXd variance = problem.P.dense().diagonal().head(6);
    const Index c = problem.C.cols();
    MatrixXd seen(problem.z.rows(), problem.z.D.cols() + 6);
    seen << problem.z.D, problem.z.sigma.asDiagonal() * innovation.PHt.topRows(6).transpose();
    MatrixXd both = MatrixXd::Zero(seen.cols(), c + 6);
    both.topLeftCorner(problem.C.rows(), c) = problem.C;
    both.bottomRightCorner(6, 6) = variance.cwiseSqrt().cwiseInverse().asDiagonal();
    problem.z.D = seen;
    const GateReport slow = gate(form_innovation(problem.P, problem.z), problem.z.groups, {both, {}},
                                 GateThresholds(kProbability));
    EXPECT_EQ(fast.accepted, slow.accepted);
    EXPECT_EQ(fast.dof, slow.dof);
    for (std::size_t g = 0; g < fast.distance.size(); ++g) {
      EXPECT_NEAR(fast.distance[g], slow.distance[g], 1e-4 * (1.0 + slow.distance[g])) << run << " " << g;
    }
  }
}

}  // namespace
}  // namespace limber
