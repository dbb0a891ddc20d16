// SPDX-License-Identifier: MIT
// A start whose points are mismatched here and there.
#include <gtest/gtest.h>

#include <random>

#include "initialize/started.hpp"
#include "limber/core/so3.hpp"

namespace limber {
namespace {

using testing::Scene;
using testing::Started;

/// Of every point in every frame with this probability: both pixels are anywhere.
Scene mismatched(Scene scene, double share) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Camera& camera = scene.calibration.cam0;
  const auto anywhere = [&] {
    return Eigen::Vector2d(camera.width * uniform(random), camera.height * uniform(random));
  };
  for (StereoFrame& frame : scene.frames) {
    for (StereoObservation& o : frame.observations) {
      if (uniform(random) < share) {
        o.uv_cam0 = anywhere();
        o.uv_cam1 = anywhere();
      }
    }
  }
  return scene;
}

/// Angle between the smoothed attitudes at the end of the window that both have [rad].
double apart(const Started& a, const Started& b) {
  const std::size_t k = std::min(a.result.trajectory.size(), b.result.trajectory.size()) - 1;
  return so3_log(a.result.trajectory[k].nav.T_world_body.R.transpose() *
                 b.result.trajectory[k].nav.T_world_body.R)
      .norm();
}

struct Case {
  double share;
  double apart;  ///< [rad]: a third of all pixels leaves half of them to a start
};
class StartMismatches : public ::testing::TestWithParam<Case> {};

TEST_P(StartMismatches, LeaveTheStartWhereItIsWithoutThem) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene scene = make_scene(testing::of_seed(seed));
    const NavigatorOptions options = testing::options_of(scene, Method::kLcekf);
    const Started sound = testing::start(scene, options);
    const Started found = testing::start(mismatched(scene, GetParam().share), options);
    ASSERT_TRUE(found.result.solved) << seed;
    EXPECT_LT(apart(sound, found), GetParam().apart) << seed;
    const auto speed = [](const Started& s) { return s.result.initial.nav.v_world_body.norm(); };
    EXPECT_NEAR(speed(found) / speed(sound), 1.0, 0.05) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Shares, StartMismatches, ::testing::Values(Case{0.1, 0.01}, Case{0.3, 0.03}),
                         [](const auto& info) { return info.param.share < 0.2 ? "tenth" : "third"; });

}  // namespace
}  // namespace limber
