// SPDX-License-Identifier: MIT
#include "limber/core/pose.hpp"

#include <gtest/gtest.h>

#include "random_geometry.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::Generator;

TEST(Pose, DefaultIsIdentity) {
  const Vector3d p(1.0, 2.0, 3.0);
  EXPECT_EQ(Pose{} * p, p);
}

TEST(Pose, MapsByRotatingThenTranslating) {
  const Pose T_world_body{so3_exp({0.0, 0.0, 0.5 * 3.14159265358979323846}), {10.0, 0.0, 0.0}};
  EXPECT_LE((T_world_body * Vector3d(1.0, 0.0, 0.0) - Vector3d(10.0, 1.0, 0.0)).norm(), 1e-14);
}

TEST(Pose, CompositionMapsAsOneAfterTheOther) {
  Generator generator(1);
  for (int k = 0; k < 20; ++k) {
    const Pose T_world_imu = testing::random_pose(generator, 10.0);
    const Pose T_imu_cam0 = testing::random_pose(generator, 1.0);
    const Vector3d p_cam0 = testing::random_vector(generator, 5.0);
    const Pose T_world_cam0 = T_world_imu * T_imu_cam0;
    EXPECT_LE((T_world_cam0 * p_cam0 - T_world_imu * (T_imu_cam0 * p_cam0)).norm(), 1e-13);
  }
}

TEST(Pose, InverseUndoesOnBothSides) {
  Generator generator(2);
  for (int k = 0; k < 20; ++k) {
    const Pose T = testing::random_pose(generator, 10.0);
    for (const Pose& identity : {T * T.inverse(), T.inverse() * T}) {
      EXPECT_LE((identity.R - Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
      EXPECT_LE(identity.p.norm(), 1e-13);
    }
  }
}

}  // namespace
}  // namespace limber
