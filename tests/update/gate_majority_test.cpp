// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "limber/update/frame_innovation.hpp"
#include "limber/update/gate.hpp"
#include "random_frame.hpp"

/// Where most points may be of something that moves.
namespace limber {
namespace {

using Eigen::VectorXd;
using testing::draw_residual;
using testing::Generator;
using testing::random_frame;
using testing::StereoProblem;

/// The same where pose and map were known so many times better.
StereoProblem with_state_known(StereoProblem problem, double times) {
  problem.P.assign(problem.P.dense() / (times * times));
  return problem;
}

/// Adds what a pose that is off by so many standard deviations does to the groups from `first` on.
void move_pose(StereoProblem& problem, std::size_t first, double sigmas) {
  const VectorXd dx = sigmas * problem.P.dense().diagonal().head(6).cwiseSqrt();
  const VectorXd moved = problem.H().leftCols(6) * dx;
  for (std::size_t g = first; g < problem.z.groups.size(); ++g) {
    const RowGroup& group = problem.z.groups[g];
    problem.z.residual.segment(group.row, group.rows) += moved.segment(group.row, group.rows);
  }
}

GateReport gated_where_most_may_move(const StereoProblem& problem, const ParameterErrorModel& model) {
  const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
  return gate(frame.innovation, frame.groups, model, GateThresholds(0.999), frame.by_pose);
}

/// A body that fills two thirds of the view and goes with the camera.
TEST(GateMajority, WhereMostMoveThoseThatThePredictionKnowsStand) {
  Generator generator(21);
  for (int run = 0; run < 6; ++run) {
    const double times = run < 3 ? 1.0 : 100.0;
    StereoProblem problem = with_state_known(random_frame(generator, 30), times);
    draw_residual(generator, problem);
    move_pose(problem, 10, 400.0 * times);
    for (const ParameterErrorModel& model : {ParameterErrorModel{}, problem.constrained()}) {
      const GateReport report = gated_where_most_may_move(problem, model);
      EXPECT_FALSE(report.overruled) << run;
      EXPECT_GE(std::count(report.accepted.begin(), report.accepted.begin() + 10, true), 8) << run;
      EXPECT_LE(std::count(report.accepted.begin() + 10, report.accepted.end(), true), 2) << run;
    }
  }
}

/// Then every point says the same, those that cannot tell as well: an update by the others takes them along.
TEST(GateMajority, WhereTheStateIsWrongNoMinorityStands) {
  Generator generator(22);
  int overruled = 0;
  for (const double sigmas : {5.0, 10.0, 20.0, 40.0, 80.0}) {
    StereoProblem problem = random_frame(generator, 30);
    draw_residual(generator, problem);
    move_pose(problem, 0, sigmas);
    const GateReport report = gated_where_most_may_move(problem, problem.constrained());
    EXPECT_TRUE(report.overruled ||
                2 * std::count(report.accepted.begin(), report.accepted.end(), true) >= 30)
        << sigmas;
    overruled += report.overruled ? 1 : 0;
  }
  EXPECT_GE(overruled, 2);
}

/// Pixels that are anywhere in the image.
void mismatch(Generator& generator, StereoProblem& problem, std::size_t first) {
  for (std::size_t g = first; g < problem.z.groups.size(); ++g) {
    const RowGroup& group = problem.z.groups[g];
    problem.z.residual.segment(group.row, group.rows) +=
        200.0 *
        VectorXd::NullaryExpr(group.rows, [&] { return std::normal_distribution<double>()(generator); });
  }
}

/// Of eight points as of thirty: no five of the right ones are asked for.
TEST(GateMajority, WhereMostAreMismatchedTheyAgreeOnNothing) {
  Generator generator(23);
  for (const std::size_t points : {8u, 30u}) {
    for (const std::size_t right : {std::size_t{0}, points * 3 / 8}) {
      StereoProblem problem = random_frame(generator, static_cast<int>(points));
      draw_residual(generator, problem);
      mismatch(generator, problem, right);
      const ParameterErrorModel trusted;
      const GateReport report = gated_where_most_may_move(problem, trusted);
      const auto accepted_from = [&](std::size_t a, std::size_t b) {
        return std::count(report.accepted.begin() + static_cast<std::ptrdiff_t>(a),
                          report.accepted.begin() + static_cast<std::ptrdiff_t>(b), true);
      };
      EXPECT_FALSE(report.overruled) << points << " " << right;
      EXPECT_GE(accepted_from(0, right) + 1, static_cast<std::ptrdiff_t>(right)) << points;
      EXPECT_LE(accepted_from(right, points), 1) << points << " " << right;
      const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
      EXPECT_TRUE(gate(frame.innovation, frame.groups, trusted, GateThresholds(0.999)).overruled)
          << "nobody knows the prediction: " << points << " " << right;
    }
  }
}

}  // namespace
}  // namespace limber
