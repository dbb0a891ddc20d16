// SPDX-License-Identifier: MIT
// Where in its map a frame's stereo points put the body.
#include "navigate/stereo_pose.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "limber/core/so3.hpp"
#include "scene.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using testing::Feeder;
using testing::kMs;
using testing::make_scene;
using testing::Scene;
using testing::with_method;

/// A map of two seconds whose body was taken away, and the frame after it.
struct Lost {
  Scene scene;
  Estimate map;
  StereoFrame frame;
  Pose truth;
};

Lost lost_body() {
  Scene scene = make_scene({});
  Feeder feeder(scene, with_method(scene, Method::kEkf));
  std::size_t k = 0;
  for (; scene.frames[k].t_ns <= 2000 * kMs; ++k) {
    (void)feeder.process(scene.frames[k]);
  }
  Estimate map = feeder.navigator.estimate();
  NavigationState nav = map.nav();
  nav.T_world_body = {so3_exp(Vector3d(0.5, -2.0, 1.0)), Vector3d(30.0, -20.0, 10.0)};
  map.set_nav(nav);
  return {scene, map, scene.frames[k], scene.truth[k].T_world_body};
}

void expect_near(const std::optional<Pose>& found, const Pose& truth, double metres, double radians) {
  ASSERT_TRUE(found);
  EXPECT_LE((found->p - truth.p).norm(), metres);
  EXPECT_LE(so3_log(truth.R.transpose() * found->R).norm(), radians);
}

TEST(BodyByStereo, IsFoundWhereverTheEstimateHasIt) {
  const Lost lost = lost_body();
  expect_near(detail::body_by_stereo(lost.map, lost.frame, mount(lost.scene.calibration)), lost.truth, 0.2,
              0.05);
}

TEST(BodyByStereo, IsFoundAmongMismatchesAndByABaselineThatIsTooShort) {
  Lost lost = lost_body();
  lost.scene.calibration.theta.tail<3>() *= 0.8;
  std::vector<StereoObservation>& points = lost.frame.observations;
  for (std::size_t k = 0; k + 4 < points.size(); k += 4) {
    std::swap(points[k].track_id, points[k + 1].track_id);
  }
  expect_near(detail::body_by_stereo(lost.map, lost.frame, mount(lost.scene.calibration)), lost.truth, 0.5,
              0.1);
}

TEST(BodyByStereo, IsUnknownByFewPointsOrByOneCamera) {
  const Lost lost = lost_body();
  StereoFrame few = lost.frame, left = lost.frame;
  few.observations.resize(9);
  for (StereoObservation& point : left.observations) {
    point.in_cam1 = false;
  }
  EXPECT_FALSE(detail::body_by_stereo(lost.map, few, mount(lost.scene.calibration)));
  EXPECT_FALSE(detail::body_by_stereo(lost.map, left, mount(lost.scene.calibration)));
}

}  // namespace
}  // namespace limber
