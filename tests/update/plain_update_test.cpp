// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "check_covariance.hpp"
#include "limber/core/dense.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/update/innovation.hpp"
#include "limber/update/update.hpp"
#include "message_of.hpp"
#include "stereo_problem.hpp"

namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::message_of;
using testing::prior_sigma;
using testing::relative_difference;
using testing::StereoProblem;
using testing::Updated;
using testing::updated;

StereoProblem small_problem(Generator& generator, int count = 6) {
  return testing::make_problem(generator, "", testing::stereo_rig(0.5),
                               testing::random_points(generator, count, 2.0, 20.0));
}

TEST(Update, WithoutConstraintIsTheTextbookEkf) {
  Generator generator(1);
  for (int k = 0; k < 30; ++k) {
    const StereoProblem problem = small_problem(generator, 1 + k);
    const Updated expected = testing::textbook_ekf(problem);
    const Updated found = updated(problem, {MatrixXd(6, 0), {}});
    const VectorXd sigma = prior_sigma(problem.P);
    EXPECT_EQ(found.report.status, UpdateStatus::kUpdated);
    EXPECT_EQ(found.report.dof, problem.z.rows());
    EXPECT_EQ(found.report.rank, 0);
    EXPECT_LE(relative_difference(found.report.dx, expected.report.dx, sigma), 1e-12);
    EXPECT_LE(relative_difference(found.P, expected.P, sigma), 1e-12);
    EXPECT_NEAR(found.report.nis, expected.report.nis, 1e-12 * expected.report.nis);
  }
}

TEST(Update, ConstraintsThatTouchNoRowChangeNothing) {
  Generator generator(2);
  StereoProblem problem = small_problem(generator);
  problem.z.D.setZero();
  const Updated constrained = updated(problem, problem.constrained());
  const Updated plain = updated(problem, {});
  EXPECT_EQ(constrained.report.dx, plain.report.dx);
  EXPECT_EQ(constrained.P, plain.P);
}

TEST(Update, ScalarOnPaperGivesTheGainByHand) {
  // Prior variance 4, two equal measurements of variance 4 each: half as uncertain twice over.
  Covariance P;
  P.append(3);
  P.set_diagonal_block(0, 4.0 * Eigen::Matrix3d::Identity());
  LinearMeasurement z;
  z.residual = Eigen::Vector2d(3.0, 0.0);
  z.sigma = Eigen::Vector2d(2.0, 2.0);
  z.H.blocks = {{0, 0, (Eigen::Matrix<double, 2, 3>() << 1, 0, 0, 0, 1, 0).finished()}};
  z.groups = {{0, 2}};
  const UpdateReport report = update(P, z, {});
  EXPECT_LE((report.dx - Eigen::Vector3d(1.5, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_LE((P.dense().diagonal() - Eigen::Vector3d(2.0, 2.0, 4.0)).norm(), 1e-15);
  EXPECT_NEAR(report.nis, 9.0 / 8.0, 1e-15);
}

TEST(Update, AConstraintOnPaperLeavesTheDifferenceOfTwoPixels) {
  // Both rows see x and are shifted together by the parameter; only their difference can be trusted, and
  // that does not depend on x.
  Covariance P;
  P.append(3);
  P.set_diagonal_block(0, Eigen::Matrix3d::Identity());
  LinearMeasurement z;
  z.residual = Eigen::Vector2d(5.0, 5.0);
  z.sigma = Eigen::Vector2d::Ones();
  z.H.blocks = {{0, 0, (Eigen::Matrix<double, 2, 3>() << 1, 0, 0, 1, 0, 0).finished()}};
  z.D = Eigen::Vector2d::Ones();
  z.groups = {{0, 2}};
  const UpdateReport report = update(P, z, {MatrixXd::Identity(1, 1), {}});
  EXPECT_EQ(report.status, UpdateStatus::kUpdated);
  EXPECT_EQ(report.rank, 1);
  EXPECT_EQ(report.dof, 1);
  EXPECT_LE(report.dx.norm(), 1e-15);
  EXPECT_NEAR(report.nis, 0.0, 1e-15);
  EXPECT_LE((P.dense() - MatrixXd::Identity(3, 3)).norm(), 1e-15);
}

TEST(Update, AnEmptyMeasurementChangesNothing) {
  Generator generator(3);
  StereoProblem problem = small_problem(generator);
  const MatrixXd before = problem.P.dense();
  LinearMeasurement empty;
  empty.D.resize(0, 6);
  const UpdateReport report = update(problem.P, empty, problem.constrained());
  EXPECT_EQ(report.status, UpdateStatus::kEmpty);
  EXPECT_EQ(report.dx, VectorXd::Zero(before.rows()));
  EXPECT_TRUE(problem.P.dense() == before);
  EXPECT_EQ(update_gain_form(problem.P, empty, problem.constrained()).status, UpdateStatus::kEmpty);
}

TEST(Update, AMeasurementThatTheConstraintsUseUpChangesNothing) {
  Generator generator(4);
  std::vector<testing::SeenPoint> points = testing::random_points(generator, 3, 2.0, 20.0);
  for (testing::SeenPoint& point : points) {
    point.in_cam0 = false;
  }
  StereoProblem problem = testing::make_problem(generator, "", testing::stereo_rig(0.5), points);
  const MatrixXd before = problem.P.dense();
  const UpdateReport report = update(problem.P, problem.z, problem.constrained());
  EXPECT_EQ(report.status, UpdateStatus::kEmpty);
  EXPECT_TRUE(report.dx.isZero(0.0));
  EXPECT_TRUE(problem.P.dense() == before);
}

TEST(Update, ABrokenCovarianceIsReportedAndLeftAsItWas) {
  Generator generator(5);
  const StereoProblem healthy = small_problem(generator);
  for (const double variance : {-1e6, std::numeric_limits<double>::quiet_NaN()}) {
    Covariance broken = healthy.P;
    broken.set_diagonal_block(0, variance * Eigen::Matrix3d::Identity());
    for (const ParameterErrorModel& model : {ParameterErrorModel{}, healthy.constrained()}) {
      for (const bool gain_form : {false, true}) {
        Covariance P = broken;
        const UpdateReport report =
            gain_form ? update_gain_form(P, healthy.z, model) : update(P, healthy.z, model);
        EXPECT_EQ(report.status, UpdateStatus::kSingularInnovation);
        EXPECT_EQ(report.dx, VectorXd::Zero(P.size()));
        // The same bits, a NaN included.
        const MatrixXd before = broken.dense();
        const MatrixXd after = P.dense();
        EXPECT_EQ(std::memcmp(after.data(), before.data(), sizeof(double) * after.size()), 0);
      }
    }
  }
}

TEST(Update, ShapesThatDisagreeAreRefusedWithBothShapes) {
  Generator generator(6);
  StereoProblem problem = small_problem(generator);  // 24 rows, 39 states
  const MatrixXd before = problem.P.dense();
  const auto expect_refusal = [&](const StereoProblem& bad, const ParameterErrorModel& model,
                                  const std::vector<std::string>& parts) {
    for (const bool gain_form : {false, true}) {
      Covariance P = bad.P;
      const std::string message = message_of(
          [&] { (void)(gain_form ? update_gain_form(P, bad.z, model) : update(P, bad.z, model)); });
      for (const std::string& part : parts) {
        EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' is not in: " << message;
      }
      EXPECT_TRUE(P.dense() == before);
    }
  };
  expect_refusal(problem, {MatrixXd::Identity(5, 5), {}}, {"6 columns", "5 rows"});
  expect_refusal(problem, {{}, MatrixXd::Identity(7, 7)}, {"6 columns", "7"});

  StereoProblem bad = problem;
  bad.z.sigma.conservativeResize(23);
  expect_refusal(bad, {}, {"r has 24", "sigma 23"});
  bad = problem;
  bad.z.D.conservativeResize(22, 6);
  expect_refusal(bad, {}, {"r has 24", "D 22x6"});
  bad = problem;
  bad.z.H.blocks.back().col = 37;
  expect_refusal(bad, {}, {"37", "P is 39"});
  bad = problem;
  bad.z.H.blocks.back().row = 23;
  expect_refusal(bad, {}, {"23", "r has 24"});
  bad.z.H.blocks.back().row = -2;
  expect_refusal(bad, {}, {"-2"});
}

TEST(Update, ValuesThatAreNoNumbersAreRefused) {
  Generator generator(7);
  const StereoProblem problem = small_problem(generator);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Spoil = std::function<void(LinearMeasurement&)>;
  const auto update_spoilt = [&](const Spoil& spoil) {
    Covariance P = problem.P;
    LinearMeasurement z = problem.z;
    spoil(z);
    try {
      (void)update(P, z, problem.constrained());
    } catch (...) {
      EXPECT_TRUE(P.dense() == problem.P.dense());
      throw;
    }
  };
  for (const double sigma : {nan, 0.0, -0.5}) {
    EXPECT_THROW(update_spoilt([&](LinearMeasurement& z) { z.sigma(3) = sigma; }), std::invalid_argument);
  }
  // What a filter forms of its own state: then it is the filter that is lost.
  for (const Spoil& spoil : std::vector<Spoil>{
           [&](LinearMeasurement& z) { z.residual(3) = nan; },
           [&](LinearMeasurement& z) { z.D(3, 2) = nan; },
           [&](LinearMeasurement& z) { z.H.blocks[2].value(1, 1) = nan; },
       }) {
    EXPECT_THROW(update_spoilt(spoil), DivergenceError);
  }
}

TEST(FormInnovation, IsTheDenseOneInUnitsOfTheNoise) {
  Generator generator(8);
  for (int k = 0; k < 10; ++k) {
    StereoProblem problem = small_problem(generator, 2 + k);
    problem.z.sigma = (0.5 * testing::random_normal(generator, problem.z.rows())).cwiseAbs().array() + 0.2;
    const Innovation innovation = form_innovation(problem.P, problem.z);
    const MatrixXd W = problem.z.sigma.cwiseInverse().asDiagonal();
    const MatrixXd H = multiply(W, problem.H());
    const MatrixXd PHt = multiply(problem.P.dense(), transposed(H));
    const MatrixXd S = multiply(H, PHt) + MatrixXd::Identity(H.rows(), H.rows());
    EXPECT_LE((innovation.r - W * problem.z.residual).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LE((innovation.D - W * problem.z.D).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE((innovation.PHt - PHt).cwiseAbs().maxCoeff(), 1e-12 * PHt.cwiseAbs().maxCoeff());
    EXPECT_LE((innovation.S - S).cwiseAbs().maxCoeff(), 1e-12 * S.cwiseAbs().maxCoeff());
  }
}

}  // namespace
}  // namespace limber
