// SPDX-License-Identifier: MIT
#include "limber/core/rotation_fit.hpp"

#include <gtest/gtest.h>

#include "limber/core/so3.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(RotationFit, FindsTheTurnAndTheFactorOfVectorsInAPlaneToo) {
  const Matrix3d turn = so3_exp(Vector3d(0.4, -2.0, 0.7));
  for (const double off_plane : {1.0, 0.0}) {
    Matrix3d correlation = Matrix3d::Zero();
    double squared = 0.0;
    for (const Vector3d& x : {Vector3d(1.0, 2.0, 3.0 * off_plane), Vector3d(-2.0, 1.0, 0.5 * off_plane),
                              Vector3d(0.3, -1.0, off_plane)}) {
      correlation += 2.0 * (turn * x) * x.transpose();
      squared += x.squaredNorm();
    }
    const RotationFit found = fit_rotation(correlation);
    EXPECT_LE((found.R - turn).norm(), 1e-12);
    EXPECT_NEAR(found.agreement / squared, 2.0, 1e-12);
  }
}

TEST(RotationFit, IsNeverAReflection) {
  const RotationFit found = fit_rotation(Vector3d(3.0, 2.0, -1.0).asDiagonal());
  EXPECT_NEAR(found.R.determinant(), 1.0, 1e-14);
  EXPECT_NEAR(found.agreement, 3.0 + 2.0 - 1.0, 1e-14);
}

}  // namespace
}  // namespace limber
