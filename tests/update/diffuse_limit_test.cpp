// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "limber/core/dense.hpp"
#include "limber/update/update.hpp"
#include "stereo_problem.hpp"

/// The constrained update as the limit of updates that know how uncertain theta is: the difference falls as
/// one over the variance.
namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::prior_sigma;
using testing::relative_difference;
using testing::StereoProblem;
using testing::Updated;
using testing::updated;

/// theta as a state of its own: variance times one plausible error each, uncorrelated with all others.
Updated with_theta_in_the_state(const StereoProblem& problem, double variance) {
  const Index n = problem.P.size();
  StereoProblem full = problem;
  full.P.append(6);
  full.P.set_diagonal_block(n, variance * multiply(problem.C, transposed(problem.C)));
  for (Index row = 0; row < full.z.rows(); row += 2) {
    full.z.H.blocks.push_back({row, n, problem.z.D.block<2, 3>(row, 0)});
    full.z.H.blocks.push_back({row, n + 3, problem.z.D.block<2, 3>(row, 3)});
  }
  full.z.D.resize(0, 0);
  Updated out = updated(full, {});
  out.report.dx.conservativeResize(n);
  out.P.conservativeResize(n, n);
  return out;
}

Updated with_white_theta(const StereoProblem& problem, double variance) {
  return updated(problem, {{}, variance * multiply(problem.C, transposed(problem.C))});
}

std::vector<StereoProblem> problems(Generator& generator) {
  std::vector<StereoProblem> out;
  for (int k = 0; k < 8; ++k) {
    out.push_back(testing::make_problem(
        generator, "problem " + std::to_string(k),
        testing::stereo_rig(k % 2 == 0 ? 0.12 : 2.0, k < 4 ? BodyFrame::kImu : BodyFrame::kMiddleOfBaseline),
        testing::random_points(generator, 12 + 2 * k, 2.0, 20.0)));
  }
  return out;
}

double difference(const Updated& a, const Updated& b, const VectorXd& sigma) {
  return std::max(relative_difference(a.report.dx, b.report.dx, sigma), relative_difference(a.P, b.P, sigma));
}

/// The range in which theory speaks alone. Below a variance of 100 the prior of theta still counts. Rounding
/// grows in proportion to the variance, about 1e-14 of a sigma times it, while the difference falls: they
/// meet at 1e7, on some processors at 1e6; at 1e5 rounding is a thousandth of the difference.
constexpr double kFirstVariance = 1e2;
constexpr std::array kVariances = {1e3, 1e4, 1e5};

void expect_limit(const std::function<Updated(const StereoProblem&, double)>& update_at) {
  Generator generator(1);
  for (const StereoProblem& problem : problems(generator)) {
    const VectorXd sigma = prior_sigma(problem.P);
    const Updated limit = updated(problem, problem.constrained());
    ASSERT_EQ(limit.report.rank, 6) << problem.name;
    double last = difference(update_at(problem, kFirstVariance), limit, sigma);
    EXPECT_GT(last, 1e-4) << problem.name << ": nothing to fall";
    for (const double variance : kVariances) {
      const double now = difference(update_at(problem, variance), limit, sigma);
      EXPECT_NEAR(std::log10(now / last), -1.0, 0.02) << problem.name << ", variance " << variance;
      last = now;
    }
    EXPECT_LE(difference(update_at(problem, 1e6), limit, sigma), 1e-6) << problem.name;
  }
}

TEST(SoftUpdate, ConvergesToTheConstrainedOneAsOneOverTheVariance) { expect_limit(with_white_theta); }

TEST(EkfFullUpdate, WithDiffuseThetaConvergesToTheConstrainedOneAsOneOverTheVariance) {
  expect_limit(with_theta_in_the_state);
}

TEST(SoftUpdate, IsTheUpdateWithThetaInTheStateAtAnyFiniteVariance) {
  Generator generator(2);
  for (const StereoProblem& problem : problems(generator)) {
    for (const double variance : {0.01, 1.0, 100.0}) {
      EXPECT_LE(difference(with_white_theta(problem, variance), with_theta_in_the_state(problem, variance),
                           prior_sigma(problem.P)),
                1e-10)
          << problem.name;
    }
  }
}

TEST(SoftUpdate, WithoutVarianceIsThePlainEkf) {
  Generator generator(3);
  for (const StereoProblem& problem : problems(generator)) {
    const Updated soft = with_white_theta(problem, 0.0);
    const Updated ekf = updated(problem, {});
    EXPECT_EQ(soft.report.dx, ekf.report.dx) << problem.name;
    EXPECT_EQ(soft.P, ekf.P) << problem.name;
  }
}

TEST(SoftUpdate, AddsToTheConstraintWhatTheConstraintDoesNotCover) {
  Generator generator(4);
  for (const StereoProblem& problem : problems(generator)) {
    // Soft in a constrained direction: says nothing new. Soft in the others: makes the gain more careful.
    const MatrixXd rotation = problem.C.leftCols<3>();
    const MatrixXd translation = problem.C.rightCols<3>();
    const Updated hard = updated(problem, {rotation, {}});
    const Updated both = updated(problem, {rotation, 100.0 * multiply(rotation, transposed(rotation))});
    EXPECT_LE(difference(both, hard, prior_sigma(problem.P)), 1e-9) << problem.name;
    const Updated careful = updated(problem, {rotation, multiply(translation, transposed(translation))});
    EXPECT_GT(careful.P.trace(), hard.P.trace()) << problem.name;
    EXPECT_LT(careful.P.trace(), updated(problem, problem.constrained()).P.trace()) << problem.name;
  }
}

}  // namespace
}  // namespace limber
