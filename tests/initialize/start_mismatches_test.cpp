// SPDX-License-Identifier: MIT
// A start whose points are mismatched here and there.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "initialize/started.hpp"
#include "limber/core/so3.hpp"
#include "mismatch.hpp"

namespace limber {
namespace {

using testing::Scene;
using testing::Started;

Scene mismatched(Scene scene, double share) {
  testing::mismatch(scene.frames, scene.calibration.cam0, share, std::mt19937(5));
  return scene;
}

const Eigen::Matrix3d& attitude(const Started& start, std::size_t frame) {
  return start.result.trajectory[frame].nav.T_world_body.R;
}

/// The last frame that both windows have.
std::size_t last_of(const Started& a, const Started& b) {
  return std::min(a.result.trajectory.size(), b.result.trajectory.size()) - 1;
}

/// How much the body's vertical differs at the end [rad]. Which way is ahead is a convention of each start.
double tilt_apart(const Started& a, const Started& b) {
  const std::size_t k = last_of(a, b);
  return (attitude(a, k).row(2) - attitude(b, k).row(2)).norm();
}

/// How much the turn from the first frame to the last one differs [rad].
double turn_apart(const Started& a, const Started& b) {
  const std::size_t k = last_of(a, b);
  const auto turn = [&](const Started& s) -> Eigen::Matrix3d {
    return attitude(s, 0).transpose() * attitude(s, k);
  };
  return so3_log(turn(a).transpose() * turn(b)).norm();
}

void expect_same(const Started& sound, const Started& found) {
  ASSERT_TRUE(found.result.solved);
  EXPECT_LT(tilt_apart(sound, found), 0.01);
  EXPECT_LT(found.result.report.tilt_sigma, 2.0 * sound.result.report.tilt_sigma);
  EXPECT_LT(turn_apart(sound, found), 0.003);
  const auto speed = [](const Started& s) { return s.result.initial.nav.v_world_body.norm(); };
  EXPECT_NEAR(speed(found) / speed(sound), 1.0, 0.05);
}

void expect_same_start(std::uint64_t seed, const std::vector<double>& shares) {
  const Scene scene = make_scene(testing::of_seed(seed));
  const NavigatorOptions options = testing::options_of(scene, Method::kLcekf);
  const Started sound = testing::start(scene, options);
  for (const double share : shares) {
    SCOPED_TRACE(::testing::Message() << share << " of seed " << seed);
    expect_same(sound, testing::start(mismatched(scene, share), options));
  }
}

TEST(StartMismatches, LeaveTheStartWhereItIsWithoutThem) { expect_same_start(1, {0.3}); }

TEST(FullStartMismatches, LeaveTheStartWhereItIsWithoutThem) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    expect_same_start(seed, {0.1, 0.3});
  }
}

}  // namespace
}  // namespace limber
