// SPDX-License-Identifier: MIT
#include "limber/core/so3.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <vector>

#include "check_jacobian.hpp"
#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;
using testing::check_jacobian;
using testing::Generator;

template <typename Derived>
double max_abs(const Eigen::MatrixBase<Derived>& m) {
  return m.cwiseAbs().maxCoeff();
}

/// Rotation vectors at zero, tiny, around the switch to Taylor series, random, and near pi.
std::vector<Vector3d> rotation_vectors() {
  Generator generator(1);
  std::vector<Vector3d> vectors = {Vector3d::Zero(), {0.5 * pi, 0.0, 0.0}, {0.0, 0.0, -0.5 * pi}};
  for (const double angle : {1e-12, 1e-8, 0.99e-4, 1.01e-4, 1e-3, 0.3, 1.0, 2.0, 3.0, pi - 1e-3, pi - 1e-6}) {
    for (int k = 0; k < 5; ++k) {
      vectors.emplace_back(angle * testing::random_direction(generator));
    }
  }
  return vectors;
}

TEST(So3, SkewIsTheCrossProduct) {
  const Vector3d v(1.0, -2.0, 3.0);
  const Vector3d w(0.4, 0.5, -0.6);
  EXPECT_LE(max_abs(skew(v) * w - v.cross(w)), 1e-15);
}

TEST(So3, ExpIsARotation) {
  for (const Vector3d& phi : rotation_vectors()) {
    const Matrix3d R = so3_exp(phi);
    EXPECT_LE(max_abs(R * R.transpose() - Matrix3d::Identity()), 1e-14) << phi.transpose();
    EXPECT_NEAR(R.determinant(), 1.0, 1e-14);
  }
}

TEST(So3, ExpTurnsByTheAngleAboutTheAxis) {
  for (const Vector3d& phi : rotation_vectors()) {
    const double angle = phi.norm();
    if (angle < 1e-3) {
      continue;
    }
    const Matrix3d expected = Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
    EXPECT_LE(max_abs(so3_exp(phi) - expected), 1e-13) << phi.transpose();
  }
  EXPECT_LE(max_abs(so3_exp({0.0, 0.0, 0.5 * pi}) * Vector3d::UnitX() - Vector3d::UnitY()), 1e-15);
}

TEST(So3, LogUndoesExp) {
  for (const Vector3d& phi : rotation_vectors()) {
    EXPECT_LE(max_abs(so3_log(so3_exp(phi)) - phi), 1e-14 + 1e-13 * phi.norm()) << phi.transpose();
  }
}

TEST(So3, LogKeepsTheRelativePrecisionOfTinyAngles) {
  const Vector3d phi(1e-9, -2e-9, 3e-9);
  EXPECT_LE((so3_log(so3_exp(phi)) - phi).norm(), 1e-12 * phi.norm());
}

TEST(So3, ExpUndoesLogAtPi) {
  Generator generator(2);
  for (int k = 0; k < 50; ++k) {
    const Matrix3d R = so3_exp(pi * testing::random_direction(generator));
    const Vector3d phi = so3_log(R);
    EXPECT_NEAR(phi.norm(), pi, 1e-12);
    EXPECT_LE(max_abs(so3_exp(phi) - R), 1e-13);
  }
}

TEST(So3, LogOfTheLongWayRoundIsTheShortWay) {
  const Vector3d axis = Vector3d(1.0, 2.0, -2.0) / 3.0;
  EXPECT_LE(max_abs(so3_log(so3_exp(1.5 * pi * axis)) + 0.5 * pi * axis), 1e-14);
}

TEST(So3, RightJacobianMatchesCentralDifferences) {
  for (const Vector3d& phi : rotation_vectors()) {
    const Matrix3d R = so3_exp(phi);
    check_jacobian(
        so3_right_jacobian(phi),
        [&](const Eigen::VectorXd& d) { return so3_log(R.transpose() * so3_exp(phi + Vector3d(d))); }, 1e-8);
  }
}

TEST(So3, InverseRightJacobianMatchesCentralDifferences) {
  for (const Vector3d& phi : rotation_vectors()) {
    if (phi.norm() > 3.1) {
      continue;  // the logarithm jumps at pi
    }
    const Matrix3d R = so3_exp(phi);
    check_jacobian(
        so3_right_jacobian_inverse(phi),
        [&](const Eigen::VectorXd& d) { return so3_log(R * so3_exp(Vector3d(d))); }, 1e-7);
  }
}

TEST(So3, InverseRightJacobianIsTheInverse) {
  for (const Vector3d& phi : rotation_vectors()) {
    EXPECT_LE(max_abs(so3_right_jacobian(phi) * so3_right_jacobian_inverse(phi) - Matrix3d::Identity()),
              1e-12)
        << phi.transpose();
  }
}

TEST(So3, NormalizedRemovesDriftAndLeavesARotationAlone) {
  Generator generator(3);
  for (int k = 0; k < 20; ++k) {
    const Matrix3d R = testing::random_rotation(generator);
    EXPECT_LE(max_abs(so3_normalized(R) - R), 1e-14);
    Matrix3d drifted = R;
    drifted.col(0) += 1e-9 * testing::random_vector(generator, 1.0);
    const Matrix3d repaired = so3_normalized(drifted);
    EXPECT_LE(max_abs(repaired * repaired.transpose() - Matrix3d::Identity()), 1e-14);
    EXPECT_LE(max_abs(repaired - R), 2e-9);
  }
}

TEST(Euler, OrderIsZThenYThenX) {
  const Vector3d angles(0.1, -0.2, 0.3);
  const Matrix3d expected =
      so3_exp({0.0, 0.0, angles.z()}) * so3_exp({0.0, angles.y(), 0.0}) * so3_exp({angles.x(), 0.0, 0.0});
  EXPECT_LE(max_abs(rotation_from_euler_zyx(angles) - expected), 1e-15);
}

TEST(Euler, AnglesComeBackFromTheRotation) {
  Generator generator(4);
  for (int k = 0; k < 100; ++k) {
    const Vector3d angles(testing::random_scalar(generator, -pi, pi),
                          testing::random_scalar(generator, -1.5, 1.5),
                          testing::random_scalar(generator, -pi, pi));
    EXPECT_LE(max_abs(euler_zyx_from_rotation(rotation_from_euler_zyx(angles)) - angles), 1e-13);
  }
  EXPECT_LE(max_abs(euler_zyx_from_rotation(rotation_from_euler_zyx({1e-8, -2e-8, 3e-8})) -
                    Vector3d(1e-8, -2e-8, 3e-8)),
            1e-22);
}

TEST(Euler, AnglesRebuildTheRotationEvenAtGimbalLock) {
  Generator generator(5);
  for (const double gap : {0.0, 1e-12, 1e-9, 1e-6, 1e-3}) {
    for (int k = 0; k < 20; ++k) {
      const double side = k % 2 == 0 ? 1.0 : -1.0;
      const Vector3d angles(testing::random_scalar(generator, -pi, pi), side * (0.5 * pi - gap),
                            testing::random_scalar(generator, -pi, pi));
      const Matrix3d R = rotation_from_euler_zyx(angles);
      EXPECT_LE(max_abs(rotation_from_euler_zyx(euler_zyx_from_rotation(R)) - R), 1e-13)
          << angles.transpose();
    }
  }
}

TEST(Euler, AxesAreTheDerivativeOfTheRotation) {
  Generator generator(6);
  std::vector<Vector3d> cases = {Vector3d::Zero(), Vector3d::Constant(1e-8), {0.3, 0.5 * pi, -0.4}};
  for (int k = 0; k < 20; ++k) {
    cases.push_back(testing::random_vector(generator, pi));
  }
  for (const Vector3d& angles : cases) {
    const Matrix3d R = rotation_from_euler_zyx(angles);
    // R(a + d) = Exp(axes d) R to first order: a left perturbation.
    check_jacobian(
        euler_zyx_axes(angles),
        [&](const Eigen::VectorXd& d) {
          return so3_log(rotation_from_euler_zyx(angles + Vector3d(d)) * R.transpose());
        },
        1e-9);
  }
}

TEST(RotationBetween, TakesOneVectorToTheOtherByTheShortestWay) {
  Generator generator(7);
  for (int k = 0; k < 50; ++k) {
    const Vector3d from = testing::random_direction(generator);
    const Vector3d to = testing::random_direction(generator);
    const Matrix3d R = rotation_between(from, to);
    EXPECT_LE(max_abs(R * from - to), 1e-13);
    EXPECT_LE(max_abs(R * R.transpose() - Matrix3d::Identity()), 1e-13);
    EXPECT_NEAR(so3_log(R).norm(), std::acos(from.dot(to)), 1e-7);
  }
}

TEST(RotationBetween, EqualVectorsGiveIdentityAndOppositeOnesHalfATurn) {
  Generator generator(8);
  for (int k = 0; k < 50; ++k) {
    const Vector3d v = testing::random_direction(generator);
    EXPECT_LE(max_abs(rotation_between(v, v) - Matrix3d::Identity()), 1e-14);
    const Matrix3d R = rotation_between(v, -v);
    EXPECT_LE(max_abs(R * v + v), 1e-7);
    EXPECT_LE(max_abs(R * R.transpose() - Matrix3d::Identity()), 1e-14);
    EXPECT_NEAR(R.determinant(), 1.0, 1e-14);
  }
}

TEST(So3, OnlyOrthonormalMatricesOfDeterminantOneAreRotations) {
  for (const Vector3d& phi : rotation_vectors()) {
    EXPECT_TRUE(is_rotation(so3_exp(phi)));
    EXPECT_FALSE(is_rotation(-so3_exp(phi)));
    EXPECT_FALSE(is_rotation(1.01 * so3_exp(phi)));
  }
  EXPECT_FALSE(is_rotation(Matrix3d::Zero()));
  Matrix3d R = Matrix3d::Identity();
  R(2, 1) = std::nan("");
  EXPECT_FALSE(is_rotation(R));
  EXPECT_THROW(require_rotation(R, "R"), std::invalid_argument);
}

}  // namespace
}  // namespace limber
