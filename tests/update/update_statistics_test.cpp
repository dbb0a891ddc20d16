// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "check_covariance.hpp"
#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/update/update.hpp"
#include "stereo_problem.hpp"

/// Random draws of state, noise and calibration error: do the reports say the truth? A sum of chi-square
/// values is chi-square; each bound is missed by chance once in a million on either side.
namespace limber {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::Generator;
using testing::StereoProblem;

constexpr int kDraws = 2000;
constexpr double kFalseAlarm = 1e-6;

void expect_chi_square(double sum, double dof) {
  EXPECT_GE(sum, chi_square_quantile(kFalseAlarm, dof));
  EXPECT_LE(sum, chi_square_quantile(1.0 - kFalseAlarm, dof));
}

struct Sums {
  double nis = 0.0, nis_dof = 0.0, nees = 0.0, nees_dof = 0.0;
};

/// x ~ N(0, P), r = H x + noise + D C d with d ~ N(0, spread²).
Sums draw(Generator& generator, StereoProblem problem, const ParameterErrorModel& model, double spread) {
  const MatrixXd root = Cholesky(problem.P.dense()).L();
  const MatrixXd H = problem.H();
  Sums sums;
  for (int k = 0; k < kDraws; ++k) {
    const VectorXd x = root * testing::random_normal(generator, root.rows());
    problem.z.residual = H * x + problem.z.sigma.cwiseProduct(testing::random_normal(generator, H.rows())) +
                         problem.z.D * problem.C * (spread * testing::random_normal(generator, 6));
    Covariance P = problem.P;
    const UpdateReport report = update(P, problem.z, model);
    sums.nis += report.nis;
    sums.nis_dof += static_cast<double>(report.dof);
    const VectorXd error = x - report.dx;
    sums.nees += error.dot(Cholesky(P.dense()).solve(error));
    sums.nees_dof += static_cast<double>(error.size());
  }
  return sums;
}

StereoProblem problem(Generator& generator) {
  std::vector<testing::SeenPoint> points = testing::random_points(generator, 7, 2.0, 15.0);
  points[3].in_cam1 = false;
  return testing::make_problem(generator, "", testing::stereo_rig(0.5), points);
}

TEST(ConstrainedUpdate, NisAndErrorsAreChiSquareWhateverTheCalibrationError) {
  Generator generator(101);
  const StereoProblem p = problem(generator);
  for (const double spread : {0.0, 1.0, 1000.0}) {
    const Sums sums = draw(generator, p, p.constrained(), spread);
    EXPECT_EQ(sums.nis_dof, kDraws * (7 * 4 - 2 - 6));
    expect_chi_square(sums.nis, sums.nis_dof);
    expect_chi_square(sums.nees, sums.nees_dof);
  }
}

TEST(ConstrainedUpdate, WithASubsetIsConsistentAgainstErrorsInThatSubset) {
  Generator generator(102);
  StereoProblem p = problem(generator);
  p.C.rightCols<3>().setZero();  // errors in rotation only
  const Sums sums = draw(generator, p, {p.C.leftCols<3>(), {}}, 100.0);
  expect_chi_square(sums.nis, sums.nis_dof);
  expect_chi_square(sums.nees, sums.nees_dof);
}

TEST(PlainUpdate, IsConsistentWithoutCalibrationErrorAndNotWithOne) {
  Generator generator(103);
  const StereoProblem p = problem(generator);
  const Sums fine = draw(generator, p, {}, 0.0);
  expect_chi_square(fine.nis, fine.nis_dof);
  expect_chi_square(fine.nees, fine.nees_dof);
  const Sums deceived = draw(generator, p, {}, 10.0);
  EXPECT_GT(deceived.nis, 1.5 * deceived.nis_dof);
  EXPECT_GT(deceived.nees, 1.5 * deceived.nees_dof);
}

TEST(SoftUpdate, IsConsistentAgainstErrorsOfTheSizeItExpects) {
  Generator generator(104);
  const StereoProblem p = problem(generator);
  const Sums sums = draw(generator, p, {{}, 9.0 * multiply(p.C, transposed(p.C))}, 3.0);
  EXPECT_EQ(sums.nis_dof, kDraws * (7 * 4 - 2));
  expect_chi_square(sums.nis, sums.nis_dof);
  expect_chi_square(sums.nees, sums.nees_dof);
}

}  // namespace
}  // namespace limber
