// SPDX-License-Identifier: MIT
#include "initialize/window_problem.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdlib>

#include "check_covariance.hpp"
#include "check_jacobian.hpp"
#include "initialize/hand_over.hpp"
#include "initialize/window_guess.hpp"
#include "navigate/scene.hpp"

namespace limber::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using limber::testing::Scene;

/// The first frames of a scene, at a guess and a little beside it.
struct Problem {
  WindowModel model;
  WindowState state;

  explicit Problem(MotionModel motion, std::ptrdiff_t frame_count = 4) {
    limber::testing::SceneOptions options;
    options.motion = motion;
    options.points = 12;
    options.duration_s = 0.05 * static_cast<double>(frame_count + 1);
    const Scene scene = make_scene(options);
    model.options = scene.options;
    model.calibration = scene.calibration;
    model.directions = constraint_directions({ConstraintSet::Kind::kFull}, scene.calibration.theta);
    InputBuffer buffer;
    for (const InputSample& sample : scene.inputs) {
      buffer.add(sample);
    }
    std::vector<WindowFrame> frames;
    std::vector<StereoFrame> raw(scene.frames.begin(), scene.frames.begin() + frame_count);
    for (std::size_t k = 0; k < raw.size(); ++k) {
      WindowFrame frame;
      frame.nav.t_ns = raw[k].t_ns;
      frame.theta = VectorXd::Zero(6);
      if (k > 0) {
        frame.steps = buffer.steps(raw[k - 1].t_ns, raw[k].t_ns);
        if (motion == MotionModel::kConstantVelocity) {
          frame.steps.assign(1, {});
          frame.steps.front().t_end_ns = raw[k].t_ns;
          frame.steps.front().dt = 0.05;
        }
      }
      frames.push_back(frame);
    }
    state = guesses(model, frames, raw).front();
    const Index n = static_cast<Index>(frames.size()) * model.frame_size();
    limber::testing::Generator generator(3);
    state =
        moved(model, state, 1e-3 * limber::testing::random_normal(generator, n),
              1e-3 * limber::testing::random_normal(generator, 3 * static_cast<Index>(state.points.size())));
  }
};

void expect_gradient(MotionModel motion) {
  const Problem problem(motion);
  const WindowNormal normal = linearise(problem.model, problem.state);
  const Index n = normal.g.size();
  VectorXd gradient(n + normal.g_points.size());
  gradient << normal.g, normal.g_points;
  const auto cost = [&](const VectorXd& d) {
    return VectorXd::Constant(
        1,
        linearise(problem.model, moved(problem.model, problem.state, d.head(n), d.tail(d.size() - n))).cost);
  };
  limber::testing::check_jacobian(-gradient.transpose(), cost, 1e-5, 1e-6);
}

TEST(WindowProblem, ItsGradientIsThatOfItsCost) {
  expect_gradient(MotionModel::kImu);
  expect_gradient(MotionModel::kConstantVelocity);
}

TEST(WindowProblem, TheSolverComesDown) {
  Problem problem(MotionModel::kImu);
  const double before = linearise(problem.model, problem.state).cost;
  EXPECT_LT(solve_window(problem.model, problem.state, 10).cost, 0.5 * before);
}

/// The normal equations' matrix of frames and points.
MatrixXd whole(const WindowNormal& normal) {
  const Index n = normal.g.size(), points = normal.g_points.size();
  MatrixXd A(n + points, n + points);
  A.topLeftCorner(n, n) = normal.A.selfadjointView<Eigen::Lower>();
  MatrixXd W = MatrixXd::Zero(n, points);
  W(normal.layout.rest(), Eigen::all) = normal.W;
  A.topRightCorner(n, points) = W;
  A.bottomLeftCorner(points, n) = W.transpose();
  A.bottomRightCorner(points, points).setZero();
  for (std::size_t j = 0; j < normal.V.size(); ++j) {
    A.block<3, 3>(n + static_cast<Index>(3 * j), n + static_cast<Index>(3 * j)) = normal.V[j];
  }
  return A;
}

TEST(WindowProblem, CovarianceOfTheFramesIsThatOfTheWholeProblem) {
  const Problem problem(MotionModel::kImu, 12);
  const WindowNormal normal = linearise(problem.model, problem.state);
  const Index n = normal.g.size();
  const MatrixXd P = frame_covariance(normal);
  ASSERT_EQ(P.rows(), n);
  const VectorXd scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd dense = whole(normal).ldlt().solve(MatrixXd::Identity(whole(normal).rows(), n));
  EXPECT_LE((scale.asDiagonal() * (P - dense.topRows(n)) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-6);
}

/// Sums that were made at another state, close by, say the same as new ones, and so in gaps.
void expect_same_residuals(bool gap, double bias_off, double attitude_off) {
  Problem problem(MotionModel::kImu, 6);
  if (gap) {
    for (WindowFrame& frame : problem.state.frames) {
      for (std::size_t i = 2; i < std::min<std::size_t>(frame.steps.size(), 6); ++i) {
        frame.steps[i].linear_unknown.memory = frame.steps[i].angular_unknown.memory = 0.3;
      }
    }
  }
  sum_up_inputs(problem.model, problem.state);
  const auto first_sums = problem.state.frames[2].inputs;
  for (WindowFrame& frame : problem.state.frames) {
    frame.nav.bias_gyro.x() += bias_off;
    frame.nav.bias_accel.y() += 10.0 * bias_off;
    frame.nav.T_world_body.R *= so3_exp(Eigen::Vector3d(attitude_off, 0.0, 0.0));
  }
  sum_up_inputs(problem.model, problem.state);
  // What is far off, or in a gap, is summed up anew.
  EXPECT_EQ(problem.state.frames[2].inputs == first_sums, !gap && bias_off < 0.01);
  WindowState anew = problem.state;
  forget_sums(anew);
  for (std::size_t k = 1; k < anew.frames.size(); ++k) {
    const MotionResidual fast = motion_residual(problem.model, problem.state, k);
    const MotionResidual slow = motion_residual(problem.model, anew, k);
    const VectorXd sigma = slow.Q.diagonal().cwiseSqrt();
    EXPECT_LE((fast.e - slow.e).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.02) << k;
    EXPECT_LE((fast.F - slow.F).cwiseAbs().maxCoeff(), 1e-3) << k;
    EXPECT_LE((fast.Q - slow.Q).norm(), 1e-3 * slow.Q.norm()) << k;
  }
}

TEST(WindowProblem, InputsThatAreSummedUpOnceSayTheSame) {
  for (const bool gap : {false, true}) {
    expect_same_residuals(gap, 0.003, 0.05);
    expect_same_residuals(gap, 0.05, 0.05);
  }
}

/// Where all tracks end at once (repeated frames, a blank), the longest 250 are all of one side: the frames
/// of the other were dead reckoned, and poses 2.4 m off.
TEST(WindowProblem, NoFrameIsLeftWithoutPoints) {
  constexpr std::int64_t kPoints = 300;
  constexpr std::size_t kBreak = 5, kFrames = 20;
  std::vector<StereoFrame> raw(kFrames);
  for (std::size_t k = 0; k < kFrames; ++k) {
    raw[k].t_ns = static_cast<std::int64_t>(k) * 50'000'000;
    for (std::int64_t id = 0; id < kPoints; ++id) {
      const Eigen::Vector2d uv(100.0 + static_cast<double>(id), 200.0);
      raw[k].observations.push_back({id + (k < kBreak ? 0 : kPoints), uv, uv, true, true});
    }
  }
  const std::vector<WindowPoint> points = points_of(Problem(MotionModel::kImu).model, raw);
  std::vector<int> of_frame(kFrames, 0);
  for (const WindowPoint& point : points) {
    for (const WindowSighting& sighting : point.seen) {
      ++of_frame[sighting.frame];
    }
  }
  EXPECT_EQ(points.size(), 250u);
  EXPECT_GE(*std::ranges::min_element(of_frame), 100);
}

/// What FramesFactor rests on.
TEST(WindowProblem, VelocityAndBiasesAreKnownToTheirNeighboursAlone) {
  const Problem problem(MotionModel::kImu, 6);
  const WindowNormal normal = linearise(problem.model, problem.state);
  const MatrixXd A = normal.A.selfadjointView<Eigen::Lower>();
  const FrameLayout& layout = normal.layout;
  ASSERT_EQ(layout.frames * layout.size(), A.rows());
  for (Index k = 0; k < layout.frames; ++k) {
    const auto of_chain = A.middleRows(k * layout.size() + layout.pose, layout.chain);
    for (Index j = 0; j < layout.frames; ++j) {
      const auto with = of_chain.middleCols(j * layout.size(), layout.size());
      EXPECT_TRUE(with.rightCols(layout.theta).isZero(0.0)) << k << " " << j;
      EXPECT_EQ(with.isZero(0.0), std::abs(k - j) > 1) << k << " " << j;
    }
  }
}

/// A full Newton step's promise: twice what the cost could still come down, summed over all directions, in
/// variances of each. Those of weak directions (scale, tilt, biases) do not show in the cost itself.
TEST(WindowProblem, TheSolverGoesOnUntilNoDirectionIsOff) {
  Problem problem(MotionModel::kImu, 20);
  const WindowNormal normal = solve_window(problem.model, problem.state, 25);
  const MatrixXd A = whole(normal);
  VectorXd g(A.rows());
  g << normal.g, normal.g_points;
  EXPECT_LE(g.dot(A.ldlt().solve(g)), 0.01);
}

/// All lengths too short together: where the left camera and the inertial samples alone tell the scale, the
/// way back is bent in frames and inverse depths.
TEST(WindowProblem, TheSolverFindsTheScaleBack) {
  Problem problem(MotionModel::kImu, 20);
  const WindowNormal solved = solve_window(problem.model, problem.state, 100);
  ASSERT_LE(solved.left, 0.005);
  constexpr double kShorter = 0.7;
  for (WindowFrame& frame : problem.state.frames) {
    frame.nav.T_world_body.p *= kShorter;
    frame.nav.v_world_body *= kShorter;
  }
  for (WindowPoint& point : problem.state.points) {
    point.landmark.value.z() /= kShorter;
  }
  const WindowNormal again = solve_window(problem.model, problem.state, 12);
  EXPECT_NEAR(again.cost, solved.cost, 0.02);
  EXPECT_LE(again.left, 0.02);
}

/// Of what the handed-over inverse depths have in common.
double information_of(const InitialState& state) {
  const auto n = static_cast<Index>(state.landmarks.size());
  VectorXd rho(n);
  MatrixXd C(n, n);
  for (Index i = 0; i < n; ++i) {
    rho[i] = state.landmarks[static_cast<std::size_t>(i)].value.z();
    for (Index j = 0; j < n; ++j) {
      C(i, j) = state.landmarks_covariance(3 * i + 2, 3 * j + 2);
    }
  }
  return rho.dot(C.ldlt().solve(rho));
}

TEST(WindowProblem, WhatItKnowsOfTheScaleIsWhatIsHandedOver) {
  Problem problem(MotionModel::kImu, 20);
  const WindowNormal normal = solve_window(problem.model, problem.state, 25);
  const MatrixXd covariance = frame_covariance(normal);
  const double stated = scale_information(problem.model, problem.state, normal, covariance);
  InitialState handed = hand_over(problem.model, problem.state, normal, covariance);
  ASSERT_GT(handed.landmarks.size(), 3u);
  EXPECT_NEAR(stated, information_of(handed), 1e-6 * stated);
  take_noise_from_scale(handed);
  EXPECT_LT(without_noise(stated), stated);
  EXPECT_NEAR(without_noise(stated), information_of(handed), 1e-6 * stated);
}

}  // namespace
}  // namespace limber::detail
