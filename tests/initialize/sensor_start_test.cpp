// SPDX-License-Identifier: MIT
#include "limber/initialize/sensor_start.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "limber/core/time.hpp"
#include "navigate/scene.hpp"
#include "started.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using testing::make_scene;
using ::testing::Not;
using testing::of_seed;
using testing::options_of;
using testing::Scene;
using testing::SceneOptions;
using testing::start;
using testing::Started;
using L = StateLayout;

TEST(SensorStart, OfARigThatIsWrongAndMovesIsTheSameForAMethodThatDistrustsIt) {
  SceneOptions still = of_seed(3);
  SceneOptions moving = of_seed(3);
  moving.theta_error = [](double t) {
    return RigParameters(testing::scene_theta_error() * std::sin(9.0 * t));
  };
  double sigma = 0.0;
  const auto velocity_error = [&sigma](const SceneOptions& options) {
    const Scene scene = make_scene(options);
    StartOptions how;
    how.longest_s = how.longest_moving_s = 1.0;  // the same frames for both
    const Started started = start(scene, options_of(scene, Method::kLcekf), how);
    const InitialState& initial = started.result.initial;
    sigma = std::sqrt(initial.body_covariance.block<3, 3>(L::kVelocity, L::kVelocity).trace());
    return Vector3d(initial.nav.v_world_body - scene.truth[started.frames - 1].v_world_body);
  };
  const Vector3d difference = velocity_error(still) - velocity_error(moving);
  EXPECT_LE(difference.norm(), 0.02);  // [m/s]
  EXPECT_LE(difference.norm(), 0.5 * sigma);
}

TEST(SensorStart, GivesEveryFrameOfTheWindowAPoseFromTheOriginOn) {
  const Scene scene = make_scene(of_seed(1));
  const Started started = start(scene, options_of(scene, Method::kLcekf));
  ASSERT_EQ(started.result.trajectory.size(), started.frames);
  EXPECT_LE(started.result.trajectory.front().nav.T_world_body.p.norm(), 1e-3);
  for (std::size_t k = 0; k < started.frames; ++k) {
    EXPECT_EQ(started.result.trajectory[k].nav.t_ns, scene.frames[k].t_ns);
    EXPECT_LE((started.result.trajectory[k].nav.T_world_body.p - scene.truth[k].T_world_body.p).norm(), 0.1);
  }
}

/// On rendered images patches fitted to 0.02 px at first and to 0.07 px after some seconds: ten times the
/// misfit, "images and inputs agree no more" after 1.4 s, and lcekf 7.5 m off on a sound rig.
TEST(SensorStart, TakesNoFinePatchesThatDriftForAFault) {
  SceneOptions fine = of_seed(1);
  fine.noise = false;
  fine.duration_s = 2.0;
  Scene scene = make_scene(fine);
  for (StereoFrame& frame : scene.frames) {
    const double drift = 0.04 * seconds_between(scene.frames.front().t_ns, frame.t_ns);  // [px]
    for (StereoObservation& o : frame.observations) {
      const double way = static_cast<double>(o.track_id);  // another one of each track
      o.uv_cam0 += drift * Eigen::Vector2d(std::cos(way), std::sin(way));
    }
  }
  const Started started = start(scene, options_of(scene, Method::kLcekf));
  EXPECT_THAT(started.report.missing, Not(HasSubstr("agree no more")));
  EXPECT_TRUE(started.result.unused.empty());
}

/// A gyro that steps in the last tenth of a window turns its last frames away from their points. Those went
/// as mismatches, the rest fitted, and the filter took over an attitude that was off.
TEST(SensorStart, WhatAFaultAtItsEndContradictsIsNoMismatch) {
  SceneOptions long_one = of_seed(1);
  long_one.duration_s = 3.5;
  Scene scene = make_scene(long_one);
  const std::int64_t step_ns = scene.frames.front().t_ns + 2'850'000'000;
  for (InputSample& sample : scene.inputs) {
    sample.angular.z() += sample.t_ns > step_ns ? 0.3 : 0.0;
  }
  StartOptions how;
  how.scale_sigma = how.open_scale_sigma = 1e-6;  // never known
  how.longest_s = how.longest_moving_s = 3.0;
  const Started started = start(scene, options_of(scene, Method::kLcekf), how);
  EXPECT_TRUE(started.result.bias_step_ns ||
              started.report.missing.find("agree no more") != std::string::npos)
      << started.report.missing;
}

/// A filter that took over by then would be sure of a scale that nobody knows.
TEST(SensorStart, OfABodyThatMovesWaitsForTheScaleLongerThanOfOneAtRest) {
  const Scene scene = make_scene(of_seed(1));
  StartOptions how;
  how.longest_s = how.longest_moving_s = 1.0;
  const Started hasty = start(scene, options_of(scene, Method::kLcekf), how);
  ASSERT_EQ(hasty.report.status, StartStatus::kTimedOut);
  EXPECT_NE(hasty.report.missing.find("no acceleration"), std::string::npos);
  how.longest_moving_s = 30.0;
  const Started patient = start(scene, options_of(scene, Method::kLcekf), how);
  EXPECT_GT(patient.report.waited_s, 1.0);
  EXPECT_NE(patient.report.status, StartStatus::kTimedOut);
  EXPECT_LT(patient.result.report.scale_sigma, 0.5 * hasty.report.scale_sigma);
}

/// What the window learns it smooths over all of its frames; where the rig is trusted nothing is to be won.
TEST(SensorStart, WaitsOnWhileTheScaleThatItsMethodLeavesOpenGetsBetter) {
  const Scene scene = make_scene(of_seed(1));
  StartOptions how;
  how.open_scale_sigma = 0.1;
  const auto started = [&](Method method, double longest_fine_s, double fine) {
    how.longest_fine_s = longest_fine_s;
    how.fine_scale_sigma = fine;
    return start(scene, options_of(scene, method), how);
  };
  const Started at_once = started(Method::kLcekf, 0.0, 1e-6);
  ASSERT_EQ(at_once.report.status, StartStatus::kReady);
  const Started later = started(Method::kLcekf, 12.0, 0.5 * at_once.report.scale_sigma);
  EXPECT_EQ(later.report.status, StartStatus::kReady);
  EXPECT_GT(later.report.waited_s, at_once.report.waited_s);
  EXPECT_LT(later.report.scale_sigma, at_once.report.scale_sigma);
  EXPECT_EQ(started(Method::kEkf, 12.0, 1e-6).report.waited_s,
            started(Method::kEkf, 0.0, 1e-6).report.waited_s);
}

TEST(SensorStart, SaysInEveryFrameWhatTheLastSolutionDoesNotKnow) {
  const Scene scene = make_scene(of_seed(1));
  const NavigatorOptions options = options_of(scene, Method::kLcekf);
  StartOptions how;
  how.scale_sigma = how.open_scale_sigma = 1e-6;  // never known
  SensorStart start(options, scene.calibration, how);
  for (const InputSample& sample : scene.inputs) {
    start.add_imu({sample.t_ns, sample.angular, sample.linear});
  }
  for (const StereoFrame& frame : scene.frames) {
    const StartReport report = start.add_frame(frame);
    const bool solved = report.waited_s >= how.shortest_s;
    EXPECT_EQ(report.status, StartStatus::kWaiting);
    EXPECT_EQ(report.missing.find("tells the scale") != std::string::npos, solved) << report.missing;
    EXPECT_EQ(std::isfinite(report.scale_sigma) && std::isfinite(report.tilt_sigma), solved);
    EXPECT_EQ(report.waited_s, 1e-9 * static_cast<double>(frame.t_ns - scene.frames[0].t_ns));
  }
}

TEST(SensorStart, IsTheSameForMethodsThatLeaveTheSameOfTheRigOpenAndForNothingElse) {
  const Scene scene = make_scene(of_seed(3));
  const StereoCalibration& rig = scene.calibration;
  const NavigatorOptions lcekf = options_of(scene, Method::kLcekf);
  const auto same = [&](const NavigatorOptions& b) { return same_start(lcekf, rig, b, rig); };
  for (const Method method :
       {Method::kLcekf, Method::kEkfFull, Method::kSoft, Method::kConsider, Method::kAdaptive}) {
    EXPECT_TRUE(same(options_of(scene, method))) << to_string(method);
  }
  EXPECT_FALSE(same(options_of(scene, Method::kEkf)));
  EXPECT_FALSE(same(options_of(scene, Method::kMonoLeft)));
  EXPECT_FALSE(same_start(options_of(scene, Method::kEkf), rig, options_of(scene, Method::kMonoLeft), rig));
  const std::vector<std::function<void(NavigatorOptions&)>> changes = {
      [](auto& o) { o.constraints.kind = ConstraintSet::Kind::kRotationDirection; },
      [](auto& o) { o.motion = MotionModel::kConstantVelocity; },
      [](auto& o) { o.imu_noise.gyro_walk *= 2.0; },
      [](auto& o) { o.learn_imu_noise = true; },
      [](auto& o) { o.constant_velocity_noise.acceleration_density *= 2.0; },
      [](auto& o) { o.learn_motion_noise = true; },
      [](auto& o) { o.sigma_px[3] *= 2.0; },
      [](auto& o) { o.gravity = 9.8; }};
  for (std::size_t k = 0; k < changes.size(); ++k) {
    NavigatorOptions other = lcekf;
    changes[k](other);
    EXPECT_FALSE(same(other)) << k;
  }
  StereoCalibration another = rig;
  another.theta[0] += 1e-12;
  EXPECT_FALSE(same_start(lcekf, rig, lcekf, another));
  another = rig;
  another.cam1.fu += 1e-9;
  EXPECT_FALSE(same_start(lcekf, rig, lcekf, another));
}

/// A cheap accelerometer: 0.4 m/s^2 off along the vertical, and who knows how much across.
TEST(SensorStart, KnowsTheTiltLessWellByAnAccelerometerThatShowsALargeBias) {
  Scene scene = make_scene(of_seed(7));
  const NavigatorOptions options = options_of(scene, Method::kEkf);
  const double usual = start(scene, options).report.tilt_sigma;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const InputSample& sample : scene.inputs) {
    up += sample.linear;
  }
  for (InputSample& sample : scene.inputs) {
    sample.linear += 0.4 * up.normalized();
  }
  const Started cheap = start(scene, options);
  EXPECT_GT(cheap.report.tilt_sigma, 2.0 * usual);
  EXPECT_LT(cheap.report.tilt_sigma, 5.0 * usual);
  EXPECT_EQ(cheap.report.status, StartStatus::kReady) << "nothing would tell it better";
}

TEST(SensorStart, RefusesWhatIsNoFrameOfTheWindow) {
  const Scene scene = make_scene(of_seed(1));
  SensorStart start(options_of(scene, Method::kLcekf), scene.calibration);
  EXPECT_THROW((void)start.result(), std::invalid_argument);
  (void)start.add_frame(scene.frames[1]);
  EXPECT_THROW((void)start.add_frame(scene.frames[0]), std::invalid_argument);
  StereoFrame far = scene.frames[2];
  far.observations[0].uv_cam0.setConstant(1e300);
  EXPECT_THROW((void)start.add_frame(far), std::invalid_argument);
  StereoCalibration flat = scene.calibration;
  flat.cam1.fv = 0.0;
  EXPECT_THROW(SensorStart(options_of(scene, Method::kLcekf), flat), std::invalid_argument);
}

}  // namespace
}  // namespace limber
