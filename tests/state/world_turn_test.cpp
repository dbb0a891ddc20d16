// SPDX-License-Identifier: MIT
#include "limber/state/world_turn.hpp"

#include <gtest/gtest.h>

#include "limber/core/so3.hpp"
#include "small_map.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(WorldTurn, IsTheExponentialOfTheRightInvariantError) {
  testing::Generator generator(1);
  for (const double size : {0.0, 1e-6, 0.3, 3.0}) {
    const Vector3d turn = size * testing::random_normal(generator, 3).normalized();
    const Vector3d dx = testing::random_normal(generator, 3);
    // Many small steps along the same twist: each turns what was moved before, and adds its share.
    constexpr int kSteps = 100000;
    const Matrix3d step = so3_exp(turn / kSteps);
    Vector3d moved = Vector3d::Zero();
    for (int k = 0; k < kSteps; ++k) {
      moved = step * (moved + 0.5 * dx / kSteps) + 0.5 * dx / kSteps;
    }
    EXPECT_LE((turned_with_world(dx, turn) - moved).norm(), 1e-9 * dx.norm()) << size;
  }
}

}  // namespace
}  // namespace limber
