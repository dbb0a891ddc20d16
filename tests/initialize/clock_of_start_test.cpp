// SPDX-License-Identifier: MIT
// An IMU's clock that is off against the cameras' from the first sample on: a start finds it, says how well
// it is known, and what body and first map owe to it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "initialize/started.hpp"
#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "limber/navigate/navigator.hpp"

namespace limber {
namespace {

using testing::at_once;
using testing::kMs;
using testing::make_scene;
using testing::of_seed;
using testing::options_of;
using testing::Scene;
using testing::SceneOptions;

/// A scene whose samples are stamped later than they were taken.
Scene stamped_late(std::uint64_t seed, std::int64_t offset_ns, bool noise = true) {
  SceneOptions options = of_seed(seed);
  options.noise = noise;
  Scene scene = make_scene(options);
  for (InputSample& sample : scene.inputs) {
    sample.t_ns += offset_ns;
  }
  return scene;
}

SensorStartResult started(const Scene& scene, Method method, bool learns = true) {
  NavigatorOptions options = options_of(scene, method);
  options.learn_imu_clock = learns;
  return testing::start(scene, options, at_once()).result;
}

double offset_of(const SensorStartResult& result) { return to_seconds(result.initial.clock_offset_ns); }

/// The noise that is stated of the scene's gyroscope, and is not there, is as large as what its rate changes
/// by within a frame: a second or two tell the clock to a hundredth of a second.
TEST(ClockOfStart, IsFoundToItsSigma) {
  for (const std::int64_t offset_ns : {40 * kMs, 20 * kMs, -50 * kMs}) {
    for (const Method method : {Method::kLcekf, Method::kEkf}) {
      const SensorStartResult result = started(stamped_late(41, offset_ns, false), method);
      const double sigma = result.initial.clock_sigma;
      EXPECT_GT(sigma, 0.0);
      EXPECT_LE(sigma, 15e-3) << offset_ns;
      EXPECT_LE(std::abs(offset_of(result) - 1e-9 * static_cast<double>(offset_ns)), 4.0 * sigma)
          << offset_ns;
    }
  }
}

TEST(ClockOfStart, IsNotMovedWithoutReason) {
  const SensorStartResult result = started(stamped_late(42, 0), Method::kLcekf);
  EXPECT_LE(std::abs(offset_of(result)), 4.0 * result.initial.clock_sigma);
}

TEST(ClockOfStart, IsTakenForKnownUnlessAsked) {
  const SensorStartResult result = started(stamped_late(41, 20 * kMs), Method::kLcekf, false);
  EXPECT_EQ(result.initial.clock_offset_ns, 0);
  EXPECT_EQ(result.initial.clock_sigma, 0.0);
  EXPECT_EQ(result.initial.by_clock.size(), 0);
}

/// A start that corrects the clock, and one that was told by how much more: as far apart as the first says.
TEST(ClockOfStart, SaysWhatAnErrorDoes) {
  const SensorStartResult at = started(stamped_late(43, 0), Method::kEkf);
  const double found = offset_of(at);
  constexpr double kMore = 5e-3;  // [s]
  const InitialState there =
      started(stamped_late(43, -std::llround(1e9 * (found + kMore))), Method::kEkf, false).initial;
  const Eigen::VectorXd says = kMore * at.initial.by_clock;
  const NavigationState& nav = at.initial.nav;
  const Eigen::Vector3d turn = so3_log(nav.T_world_body.R.transpose() * there.nav.T_world_body.R);
  const Eigen::Vector3d velocity = there.nav.v_world_body - nav.v_world_body;
  const Eigen::Vector3d bias = there.nav.bias_gyro - nav.bias_gyro;
  EXPECT_LT((velocity - says.segment<3>(StateLayout::kVelocity)).norm(), 0.25 * velocity.norm());
  EXPECT_LT((turn - says.segment<3>(StateLayout::kAttitude)).norm(), 0.25 * turn.norm() + 1e-4);
  EXPECT_LT((bias - says.segment<3>(StateLayout::kBiasGyro)).norm(), 0.25 * bias.norm() + 1e-4);
}

/// The joint covariance against the slow, obvious one: S times the clock's variance times its transpose.
TEST(ClockOfStart, IsInTheJointCovariance) {
  const InitialState initial = started(stamped_late(44, 0), Method::kEkf).initial;
  ASSERT_FALSE(initial.landmarks.empty());
  const Scene scene = make_scene(of_seed(44));
  StateLayout layout{MotionModel::kImu};
  layout.has_supposed_steps = true;
  Estimate estimate(layout, initial.nav, initial.body_covariance, scene.calibration.theta,
                    Eigen::Matrix<double, 6, 6>::Identity());
  place_first_map(estimate, initial, scene.calibration.T_body_cam0);
  const Eigen::MatrixXd before = estimate.P().dense();
  correlate_with_clock(estimate, initial);
  const Eigen::Index body = layout.body_size(), points = initial.by_clock.size() - body;
  Eigen::VectorXd S = Eigen::VectorXd::Zero(before.rows());
  S.head(body) = initial.by_clock.head(body);
  S.segment<6>(S.size() - points - 6) = initial.by_clock.head<6>();
  S.tail(points) = initial.by_clock.tail(points);
  S(layout.clock_step()) = 1.0;
  const double variance = initial.clock_sigma * initial.clock_sigma;
  EXPECT_LE((estimate.P().dense() - before - variance * S * S.transpose()).norm(), 1e-12 * before.norm());
  EXPECT_NEAR(estimate.clock_step().sigma, initial.clock_sigma, 1e-3 * initial.clock_sigma);
}

TEST(ClockOfStart, RefusesWhatDoesNotFit) {
  const Scene scene = make_scene(of_seed(44));
  InitialState initial = started(stamped_late(44, 0), Method::kEkf).initial;
  initial.by_clock.conservativeResize(initial.by_clock.size() - 1);
  EXPECT_THROW(Navigator(options_of(scene, Method::kEkf), scene.calibration, initial), std::invalid_argument);
  initial.clock_sigma = -1.0;
  EXPECT_THROW(Navigator(options_of(scene, Method::kEkf), scene.calibration, initial), std::invalid_argument);
}

}  // namespace
}  // namespace limber
