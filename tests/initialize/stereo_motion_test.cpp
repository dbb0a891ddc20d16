// SPDX-License-Identifier: MIT
#include "limber/initialize/stereo_motion.hpp"

#include <gtest/gtest.h>

#include "window.hpp"

namespace limber {
namespace {

using testing::make_window;
using testing::SceneOptions;
using testing::Window;

double angle(const Eigen::Matrix3d& R) { return so3_log(R).norm(); }

/// @param metres, radians  largest difference to the true motion
void expect_true_motion(const SceneOptions& options, double metres, double radians) {
  const Window window = make_window(options);
  const std::vector<StampedPose> motion = window.motion();
  ASSERT_EQ(motion.size(), window.scene.frames.size());
  for (std::size_t k = 0; k < motion.size(); ++k) {
    const Pose moved = window.moved(k);
    EXPECT_EQ(motion[k].t_ns, window.scene.frames[k].t_ns);
    EXPECT_LE((motion[k].T_world_body.p - moved.p).norm(), metres) << options.seed << " " << k;
    EXPECT_LE(angle(motion[k].T_world_body.R.transpose() * moved.R), radians) << options.seed << " " << k;
  }
}

TEST(StereoMotion, IsThatOfTheRigWithoutNoise) {
  SceneOptions options;
  options.noise = false;
  expect_true_motion(options, 1e-6, 1e-7);
}

TEST(StereoMotion, IsOffByLittleWithNoise) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SceneOptions options;
    options.seed = seed;
    expect_true_motion(options, 0.04, 0.01);
  }
}

TEST(StereoMotion, TakesAWrongBaselineForAnotherScale) {
  SceneOptions options = testing::longer_baseline(1);
  options.noise = false;
  const Window window = make_window(options);
  const std::vector<StampedPose> motion = window.motion();
  const Eigen::Vector3d p_body_cam = body_from_cam0(window.scene.calibration).p;
  const auto camera = [&](const Pose& T) { return Eigen::Vector3d(T.p + T.R * p_body_cam - p_body_cam); };
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const double ratio = camera(window.moved(k)).norm() / camera(motion[k].T_world_body).norm();
    EXPECT_NEAR(ratio, 1.1, 0.01) << k;
  }
}

TEST(StereoMotion, EndsWhereTooFewPointsAreShared) {
  Window window = make_window({});
  window.scene.frames[7].observations.resize(5);
  EXPECT_EQ(window.motion().size(), 7U);
  window.scene.frames[0].observations.clear();
  EXPECT_EQ(window.motion().size(), 1U);
  EXPECT_TRUE(stereo_motion({}, window.scene.calibration).empty());
}

}  // namespace
}  // namespace limber
