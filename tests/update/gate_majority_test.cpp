// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "limber/update/frame_innovation.hpp"
#include "limber/update/gate.hpp"
#include "random_frame.hpp"

/// Where most points may be of something that moves.
namespace limber {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::draw_residual;
using testing::Generator;
using testing::random_frame;
using testing::SeenPoint;
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

GateReport gated_where_most_may_move(const StereoProblem& problem, const ParameterErrorModel& model,
                                     const std::optional<double>& usual_scatter = {}) {
  const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
  return gate(frame.innovation, frame.groups, model, GateThresholds(0.999),
              {true, frame.by_pose, {}, {}, usual_scatter});
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

/// Of a state that is known well; what is assumed of pixels is three times what they show.
StereoProblem with_quiet_pixels(Generator& generator) {
  StereoProblem problem = with_state_known(random_frame(generator, 30), 100.0);
  draw_residual(generator, problem);
  problem.z.residual /= 3.0;
  return problem;
}

/// By two sigmas of what is assumed of a pixel at first, as something does that begins to move.
TEST(GateMajority, WhereMostBeginToMoveThoseThatAreOffAsUsualStand) {
  Generator generator(23);
  int stand = 0, stand_without = 0;
  const auto is_told = [](const GateReport& report) {
    return std::count(report.accepted.begin(), report.accepted.begin() + 12, true) >= 8 &&
           std::count(report.accepted.begin() + 12, report.accepted.end(), true) <= 4;
  };
  for (int run = 0; run < 10; ++run) {
    StereoProblem problem = with_quiet_pixels(generator);
    const double usual = gated_where_most_may_move(problem, {}).scatter.value();
    for (std::size_t g = 12; g < problem.z.groups.size(); ++g) {
      const RowGroup& group = problem.z.groups[g];
      problem.z.residual.segment(group.row, group.rows) +=
          2.5 * problem.z.sigma.segment(group.row, group.rows);
    }
    for (const ParameterErrorModel& model : {ParameterErrorModel{}, problem.constrained()}) {
      stand += is_told(gated_where_most_may_move(problem, model, usual)) ? 1 : 0;
      stand_without += is_told(gated_where_most_may_move(problem, model)) ? 1 : 0;
    }
  }
  EXPECT_GE(stand, 16) << "of 20";
  EXPECT_LE(stand_without, 4) << "of 20: they move too far to test anything";
}

/// A bias that steps, or a rig that bends, is judged as if nothing were usual.
TEST(GateMajority, WhatAPoseOrARigExplainsIsNothingThatMoves) {
  Generator generator(25);
  for (int run = 0; run < 10; ++run) {
    StereoProblem problem = with_quiet_pixels(generator);
    const double usual = gated_where_most_may_move(problem, {}).scatter.value();
    const VectorXd by_rig = problem.z.D * problem.C * VectorXd::Constant(problem.C.cols(), 1.0);
    if (run % 2 == 0) {
      move_pose(problem, 0, 100.0);
    } else {
      problem.z.residual += by_rig * (3.0 * problem.z.sigma.norm() / by_rig.norm());
    }
    for (const ParameterErrorModel& model : {ParameterErrorModel{}, problem.constrained()}) {
      const GateReport report = gated_where_most_may_move(problem, model, usual);
      const GateReport without = gated_where_most_may_move(problem, model);
      EXPECT_EQ(report.accepted, without.accepted) << run;
      EXPECT_EQ(report.overruled, without.overruled) << run;
    }
  }
}

/// Images that blur, or are lit worse: no point is of something else.
TEST(GateMajority, WhereAllAreOffMoreThanUsualHardlyAnyIsRefused) {
  Generator generator(24);
  for (int run = 0; run < 10; ++run) {
    StereoProblem problem = with_quiet_pixels(generator);
    const double usual = gated_where_most_may_move(problem, {}).scatter.value();
    problem.z.residual *= 2.0;  // four times the variance
    for (const ParameterErrorModel& model : {ParameterErrorModel{}, problem.constrained()}) {
      const GateReport report = gated_where_most_may_move(problem, model, usual);
      EXPECT_GE(std::count(report.accepted.begin(), report.accepted.end(), true), 22) << run;
      EXPECT_GT(report.scatter.value(), 2.0 * usual) << run;
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

/// Of eight a pose and a rig of any size bring half together in most frames: then they overrule as before.
TEST(GateMajority, WhereMostAreMismatchedTheyAgreeOnNothing) {
  Generator generator(23);
  for (const auto& [points, right] : {std::pair{12, 4}, {30, 11}, {30, 0}}) {
    SCOPED_TRACE(::testing::Message() << right << " of " << points);
    for (int run = 0; run < 20; ++run) {
      StereoProblem problem = with_state_known(random_frame(generator, points), 100.0);
      draw_residual(generator, problem);
      mismatch(generator, problem, static_cast<std::size_t>(right));
      const GateReport report = gated_where_most_may_move(problem, {});
      EXPECT_TRUE(report.most_mismatched);
      const auto middle = report.accepted.begin() + right;
      EXPECT_GE(std::count(report.accepted.begin(), middle, true), right - 1);
      EXPECT_LE(std::count(middle, report.accepted.end(), true), 1);
      const FrameInnovation frame = form_frame_innovation(problem.P, problem.z);
      EXPECT_TRUE(gate(frame.innovation, frame.groups, {}, GateThresholds(0.999)).overruled)
          << "nobody knows the prediction";
    }
  }
}

/// Pixels whose noise stands for what lasts in them show a third of it in a frame. What moves by two of its
/// sigmas, less than half of all, is seen beside the others.
TEST(GateMajority, ComparesPointsWithHowFarHalfOfThemAreOff) {
  Generator generator(9);
  std::ptrdiff_t moving = 0, standing = 0;
  for (int run = 0; run < 20; ++run) {
    StereoProblem problem = with_state_known(random_frame(generator, 30), 100.0);
    draw_residual(generator, problem);
    problem.z.residual *= 0.3;
    for (std::size_t g = 0; g < 12; ++g) {
      const RowGroup& group = problem.z.groups[g];
      problem.z.residual.segment(group.row, group.rows) +=
          2.0 * problem.z.sigma.segment(group.row, group.rows);
    }
    const GateReport report = gated_where_most_may_move(problem, {});
    EXPECT_FALSE(report.overruled);
    moving += std::count(report.accepted.begin(), report.accepted.begin() + 12, false);
    standing += std::count(report.accepted.begin() + 12, report.accepted.end(), false);
  }
  EXPECT_GE(moving, 20 * 12 * 8 / 10);
  EXPECT_LE(standing, 20 * 18 / 50);
}

/// A point much nearer than all others may be anywhere for them: they hardly know where the right camera is.
/// Its match, if it is wrong, says of the rig what nobody can check.
TEST(GateMajority, RefusesWhatNoOtherPointCanCheck) {
  Generator generator(4);
  for (int run = 0; run < 10; ++run) {
    std::vector<SeenPoint> points = testing::random_points(generator, 24, 15.0, 30.0);
    points.push_back(testing::random_points(generator, 1, 0.3, 0.4).front());
    StereoProblem problem = testing::make_problem(generator, "", testing::stereo_rig(0.1), points);
    draw_residual(generator, problem);
    EXPECT_TRUE(gated_where_most_may_move(problem, problem.constrained()).accepted.back()) << run;
    const RowGroup& last = problem.z.groups.back();
    const Index v1 = last.row + last.rows - 1;
    problem.z.residual(v1) += 60.0;  // [px], across the epipolar line
    const GateReport report = gated_where_most_may_move(problem, problem.constrained());
    EXPECT_FALSE(report.accepted.back()) << run;
    EXPECT_LE(std::count(report.accepted.begin(), report.accepted.end(), false), 2) << run;
  }
}

/// Mismatches beside most others that are right: those do not agree with each other, and are no body.
TEST(GateMajority, WhatIsRefusedAndDisagreesIsNoBody) {
  Generator generator(24);
  for (int run = 0; run < 10; ++run) {
    StereoProblem problem = with_state_known(random_frame(generator, 40), 100.0);
    draw_residual(generator, problem);
    mismatch(generator, problem, 17);  // of 40: few enough to be gross outliers of what is constrained
    const GateReport report = gated_where_most_may_move(problem, problem.constrained());
    EXPECT_FALSE(report.overruled) << run;
    EXPECT_TRUE(report.most_refused()) << run;
    EXPECT_TRUE(report.most_mismatched) << run;
  }
}

/// As often as it is told, a thousandth; whatever the rig is, and however much less than assumed is shown.
TEST(GateMajority, RefusesGoodPointsNoMoreOftenThanItIsTold) {
  Generator generator(1);
  for (const double shown : {0.3, 0.5, 1.0}) {
    std::ptrdiff_t by_chance = 0, points = 0;
    for (int run = 0; run < 100; ++run) {
      StereoProblem problem = random_frame(generator, 20);
      draw_residual(generator, problem);
      problem.z.residual *= shown;
      problem.z.residual += problem.z.D * problem.C * VectorXd::Constant(problem.C.cols(), 10.0);
      const GateReport report = gated_where_most_may_move(problem, problem.constrained());
      EXPECT_FALSE(report.overruled) << shown;
      by_chance += std::count(report.accepted.begin(), report.accepted.end(), false);
      points += std::ssize(report.accepted);
    }
    EXPECT_LE(by_chance, 3 * points / 1000) << shown;
  }
}

}  // namespace
}  // namespace limber
