// SPDX-License-Identifier: MIT
#include "limber/measure/triangulate.hpp"

#include <gtest/gtest.h>

#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::Generator;

Pose random_stereo(Generator& generator) {
  return {testing::random_rotation(generator, 0.2),
          Vector3d(-0.3, 0.0, 0.0) + testing::random_vector(generator, 0.05)};
}

Vector3d random_point(Generator& generator, double depth) {
  return depth * Vector3d(testing::random_scalar(generator, -0.5, 0.5),
                          testing::random_scalar(generator, -0.5, 0.5), 1.0);
}

TEST(InverseDepthAlong, RecoversTheDepthOfPerfectBearings) {
  Generator generator(1);
  for (const double depth : {0.5, 3.0, 50.0, 1e4}) {
    for (int k = 0; k < 20; ++k) {
      const Pose T_cam1_cam0 = random_stereo(generator);
      const Vector3d X = random_point(generator, depth);
      const auto rho = inverse_depth_along(X.normalized(), (T_cam1_cam0 * X).normalized(), T_cam1_cam0);
      ASSERT_TRUE(rho);
      EXPECT_NEAR(*rho, 1.0 / X.norm(), 1e-13);
    }
  }
}

TEST(InverseDepthAlong, IsZeroAtInfinityAndNegativeBeyond) {
  const Pose T_cam1_cam0{Eigen::Matrix3d::Identity(), Vector3d(-0.3, 0.0, 0.0)};
  const Vector3d d0 = Vector3d::UnitZ();
  EXPECT_NEAR(*inverse_depth_along(d0, d0, T_cam1_cam0), 0.0, 1e-15);
  const Vector3d diverging = Vector3d(0.01, 0.0, 1.0).normalized();
  EXPECT_LT(*inverse_depth_along(d0, diverging, T_cam1_cam0), -0.03);
}

TEST(InverseDepthAlong, MinimisesTheMisfitOfNoisyBearings) {
  Generator generator(2);
  for (int k = 0; k < 20; ++k) {
    const Pose T = random_stereo(generator);
    const Vector3d X = random_point(generator, 4.0);
    const Vector3d d0 = X.normalized();
    const Vector3d d1 = (T * X + testing::random_vector(generator, 0.05)).normalized();
    const auto misfit = [&](double rho) { return d1.cross(T.R * d0 + rho * T.p).norm(); };
    const double rho = *inverse_depth_along(d0, d1, T);
    EXPECT_LE(misfit(rho), misfit(rho + 1e-4));
    EXPECT_LE(misfit(rho), misfit(rho - 1e-4));
  }
}

TEST(InverseDepthAlong, KnowsNothingAlongTheBaseline) {
  const Pose T_cam1_cam0{Eigen::Matrix3d::Identity(), Vector3d(0.0, 0.0, -0.3)};
  EXPECT_FALSE(inverse_depth_along(Vector3d::UnitZ(), Vector3d::UnitZ(), T_cam1_cam0));
}

TEST(TriangulateDlt, RecoversThePointOfPerfectBearings) {
  Generator generator(3);
  for (const double depth : {0.5, 3.0, 50.0, 1e3}) {
    for (int k = 0; k < 20; ++k) {
      const Pose T_cam1_cam0 = random_stereo(generator);
      const Vector3d X = random_point(generator, depth);
      const Eigen::Vector4d Xw = triangulate_dlt(X.normalized(), (T_cam1_cam0 * X).normalized(), T_cam1_cam0);
      EXPECT_NEAR(Xw.norm(), 1.0, 1e-14);
      EXPECT_GE(Xw(3), 0.0);
      EXPECT_LE((Xw.head<3>() / Xw(3) - X).norm(), 1e-13 * depth * (1.0 + depth)) << depth;
    }
  }
}

TEST(TriangulateDlt, ParallelBearingsMeetAtInfinity) {
  const Pose T_cam1_cam0{Eigen::Matrix3d::Identity(), Vector3d(-0.3, 0.0, 0.0)};
  const Vector3d d = Vector3d(0.1, -0.2, 1.0).normalized();
  const Eigen::Vector4d X = triangulate_dlt(d, d, T_cam1_cam0);
  EXPECT_NEAR(X(3), 0.0, 1e-12);
  EXPECT_NEAR(std::abs(X.head<3>().dot(d)), 1.0, 1e-12);
}

}  // namespace
}  // namespace limber
