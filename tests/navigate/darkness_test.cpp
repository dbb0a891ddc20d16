// SPDX-License-Identifier: MIT
// Images that come back after a time by the IMU alone, or by nothing.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "limber/navigate/stereo_filter.hpp"
#include "scene.hpp"

namespace limber {
namespace {

using testing::Feeder;
using testing::kMs;
using testing::make_scene;
using testing::Scene;
using testing::SceneOptions;
using testing::with_method;

Scene scene_of(double seconds, std::uint64_t seed) {
  SceneOptions how;
  how.duration_s = seconds;
  how.seed = seed;
  return make_scene(how);
}

/// A scene of 13 s by an IMU that is noisier than most.
Scene noisy_scene(std::uint64_t seed) {
  Scene scene = scene_of(13.0, seed);
  ImuNoise& noise = scene.options.imu_noise;
  noise.gyro_density = 0.01;
  noise.accel_density = 0.05;
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal(0.0, 1.0 / std::sqrt(0.005));  // 5 ms a sample
  for (InputSample& sample : scene.inputs) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      sample.angular(k) += noise.gyro_density * normal(generator);
      sample.linear(k) += noise.accel_density * normal(generator);
    }
  }
  return scene;
}

/// The pose at the end: how far off its position is [m], and its squared error over what is expected of it.
struct Error {
  double position, nees;
};

/// @param until_ns  no frame from 2 s to then
/// @param empty     frames come then, too, and show nothing
Error error_after_darkness(const Scene& scene, Method method, std::int64_t until_ns, bool empty) {
  Feeder feeder(scene, with_method(scene, method));
  for (const StereoFrame& frame : scene.frames) {
    if (frame.t_ns <= 2000 * kMs || frame.t_ns >= until_ns) {
      (void)feeder.process(frame);
    } else if (empty) {
      (void)feeder.process({frame.t_ns, {}});
    }
  }
  const Eigen::Matrix<double, 6, 1> error = testing::pose_error(feeder.navigator, scene.truth.back());
  const Eigen::Matrix<double, 6, 6> P = feeder.navigator.estimate().P().diagonal_block<6>(0);
  return {error.head<3>().norm(), error.dot(P.ldlt().solve(error)) / 6.0};
}

/// After ten seconds by the IMU alone, 5 to 14 m away, no correction is linear at the prediction.
TEST(Darkness, ImagesThatComeBackAreLinearisedWhereTheyPutTheBody) {
  for (const bool empty : {false, true}) {
    double sum = 0.0;
    for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
      const Error error = error_after_darkness(noisy_scene(seed), Method::kEkf, 12000 * kMs, empty);
      EXPECT_LE(error.position, 0.05) << seed;
      sum += error.nees;
    }
    EXPECT_LE(sum / 6.0, 2.0) << empty;  // chi-square of 36 degrees of freedom: 1 in 5000
  }
}

/// Nothing of any sensor for five seconds: the body is somewhere else, turned by any angle. Its map was given
/// up, or bent by a frame that was linear at a guess: metres off at best, and sure of it at worst.
TEST(Darkness, ImagesFindTheBodyInItsMapWhereverItWent) {
  for (const Method method : {Method::kEkf, Method::kLcekf}) {
    double sum = 0.0;
    for (const std::uint64_t seed : {1, 2, 3}) {
      Scene scene = scene_of(9.0, seed);
      std::erase_if(scene.inputs, [](const InputSample& sample) {
        return sample.t_ns > 2000 * kMs && sample.t_ns < 7000 * kMs;
      });
      const Error error = error_after_darkness(scene, method, 7000 * kMs, false);
      EXPECT_LE(error.position, 0.1) << to_string(method) << ' ' << seed;
      sum += error.nees;
    }
    EXPECT_LE(sum / 3.0, 2.5) << to_string(method);  // chi-square of 18 degrees of freedom: 1 in 2000
  }
}

}  // namespace
}  // namespace limber
