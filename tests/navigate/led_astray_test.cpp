// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "limber/navigate/stereo_filter.hpp"
#include "scene.hpp"

namespace limber {
namespace {

using testing::Feeder;
using testing::make_scene;
using testing::Scene;
using testing::SceneOptions;
using testing::with_method;

/// An image that is turned by 126 degrees, with odometry that could be far off: a linear update would lead
/// away from it, and the next one farther still. starry_night, with one camera, ended 113 m off so.
TEST(LedAstray, ACorrectionThatWouldPutPointsFartherOffIsNotMadeAndThePointsBeginAnew) {
  int astray = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SceneOptions how;
    how.duration_s = 1.5;
    how.motion = MotionModel::kOdometry;
    how.seed = seed;
    const Scene scene = make_scene(how);
    NavigatorOptions options = with_method(scene, Method::kMonoLeft);
    options.odometry_noise.sigma_v.setConstant(30.0);
    options.odometry_noise.sigma_omega.setConstant(5.0);
    Feeder feeder(scene, options);
    for (std::size_t k = 0; k < 20; ++k) {
      EXPECT_FALSE(feeder.process(scene.frames[k]).led_astray) << k;
    }
    StereoFrame turned = scene.frames[20];
    const Eigen::Vector2d centre(scene.calibration.cam0.cu, scene.calibration.cam0.cv);
    for (StereoObservation& o : turned.observations) {
      o.uv_cam0 = centre + Eigen::Rotation2Dd(2.2) * (o.uv_cam0 - centre);
    }
    feeder.feed_inputs(turned.t_ns);
    const NavigationState predicted = feeder.navigator.predict(turned.t_ns).nav;
    const FrameReport report = feeder.navigator.process(turned);
    if (report.led_astray) {
      ++astray;
      EXPECT_GE(report.removed, 20U);
      EXPECT_GE(report.initialized, 20U);
      EXPECT_EQ(feeder.navigator.estimate().nav().T_world_body.p, predicted.T_world_body.p);
    }
  }
  EXPECT_GE(astray, 3);
}

}  // namespace
}  // namespace limber
