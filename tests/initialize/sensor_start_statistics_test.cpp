// SPDX-License-Identifier: MIT
#include "limber/core/factors.hpp"
#include "limber/initialize/sensor_start.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <utility>
#include <vector>

#include "check_covariance.hpp"
#include "limber/core/so3.hpp"
#include "navigate/scene.hpp"
#include "started.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::make_scene;
using testing::of_seed;
using testing::options_of;
using testing::Scene;
using testing::SceneOptions;
using testing::start;
using testing::Started;
using L = StateLayout;

/// true = estimate ⊕ error of the body; the scene begins at the origin, level and looking along x.
VectorXd body_error(const NavigationState& estimate, const NavigationState& truth) {
  VectorXd e(15);
  e << truth.T_world_body.p - estimate.T_world_body.p,
      so3_log(estimate.T_world_body.R.transpose() * truth.T_world_body.R),
      truth.v_world_body - estimate.v_world_body, truth.bias_gyro - estimate.bias_gyro,
      truth.bias_accel - estimate.bias_accel;
  return e;
}

/// The scene's biases are small beside what a start expects of one, which NEES of 15 shows as less than 15.
/// @return how many of the ten trust a rig that they need not trust
int expect_consistent(const std::function<SceneOptions(std::uint64_t)>& make, Method method,
                      const StartOptions& how = {}) {
  constexpr int kRuns = 10;
  double nees = 0.0, map_nees = 0.0;
  int points = 0, trusting = 0;
  for (int k = 1; k <= kRuns; ++k) {
    const Scene scene = make_scene(make(static_cast<std::uint64_t>(k)));
    const Started started = start(scene, options_of(scene, method), how);
    const InitialState& initial = started.result.initial;
    trusting += initial.distrusting ? 1 : 0;
    const NavigationState& truth = scene.truth[started.frames - 1];
    const VectorXd e = body_error(initial.nav, truth).head(9);
    nees += e.dot(MatrixXd(initial.body_covariance.topLeftCorner(9, 9)).llt().solve(e)) / 9.0 / kRuns;
    const Pose T_cam0_world = (truth.T_world_body * scene.calibration.T_body_cam0).inverse();
    for (std::size_t j = 0; j < initial.landmarks.size(); ++j) {
      const Landmark& landmark = initial.landmarks[j];
      const Vector3d X = landmark.R_cam0_chart.transpose() *
                         (T_cam0_world * scene.landmarks[static_cast<std::size_t>(landmark.track_id)]);
      const Vector3d error = Vector3d(X.x() / X.z(), X.y() / X.z(), 1.0 / X.z()) - landmark.value;
      const Matrix3d P = initial.landmarks_covariance.block<3, 3>(3 * static_cast<Eigen::Index>(j),
                                                                  3 * static_cast<Eigen::Index>(j));
      map_nees += error.dot(Cholesky(P).solve(error)) / 3.0;
      ++points;
    }
  }
  EXPECT_GE(nees, 0.5);
  EXPECT_LE(nees, 1.4);
  EXPECT_GE(map_nees / points, 0.5);
  EXPECT_LE(map_nees / points, 1.4);
  return trusting;
}

TEST(SensorStart, OfATrustedRigIsAsSureAsItSays) { EXPECT_EQ(expect_consistent(of_seed, Method::kEkf), 0); }

TEST(SensorStart, OfARigThatIsTrustedAfterAllIsAsSureAsItSays) {
  const auto long_enough = [](std::uint64_t seed) {
    SceneOptions out = of_seed(seed);
    out.duration_s = 8.0;
    return out;
  };
  EXPECT_GE(expect_consistent(long_enough, Method::kAdaptive, testing::at_once()), 8);
}

TEST(SensorStart, OfARigThatIsWrongIsAsSureAsItSaysWhereTheMethodDistrustsIt) {
  const auto wrong = [](std::uint64_t seed) { return testing::wrong_rig(seed); };
  EXPECT_EQ(expect_consistent(wrong, Method::kLcekf), 0);
}

/// The filter is told a tenth of the noise that its gyro has. @return mean NEES of velocity and attitude, and
/// the factors that were found
std::pair<double, std::vector<double>> start_with_a_noisy_gyro(bool learn) {
  constexpr int kRuns = 4;
  double nees = 0.0;
  std::vector<double> factors;
  for (int k = 1; k <= kRuns; ++k) {
    const Scene scene = make_scene(of_seed(static_cast<std::uint64_t>(k)));
    NavigatorOptions options = options_of(scene, Method::kLcekf);
    options.imu_noise.gyro_density *= 0.1;
    options.learn_imu_noise = learn;
    const Started started = start(scene, options);
    const InitialState& initial = started.result.initial;
    const VectorXd e = body_error(initial.nav, scene.truth[started.frames - 1]).segment(3, 6);
    nees += e.dot(MatrixXd(initial.body_covariance.block(3, 3, 6, 6)).llt().solve(e)) / 6.0 / kRuns;
    factors.push_back(initial.imu_noise.gyro);
  }
  return {nees, factors};
}

TEST(SensorStart, FindsHowMuchNoisierThanStatedAnImuIs) {
  const auto [nees, factors] = start_with_a_noisy_gyro(true);
  EXPECT_LE(nees, 2.0);
  EXPECT_GE(*std::ranges::min_element(factors), 5.0);
  EXPECT_LE(*std::ranges::max_element(factors), 20.0);
}

/// An IMU that is `times` as noisy as stated, beside pixels that are taken to err three times as much as they
/// do.
ImuNoiseFactors found_beside_sharp_pixels(std::uint64_t seed, double times) {
  SceneOptions sharp = of_seed(seed);
  sharp.sigma_px = 0.3;
  const Scene scene = make_scene(sharp);
  NavigatorOptions options = options_of(scene, Method::kLcekf);
  options.sigma_px.setConstant(1.0);
  options.learn_pixel_noise = true;
  options.learn_imu_noise = true;
  options.imu_noise.gyro_density /= times;
  options.imu_noise.accel_density /= times;
  return start(scene, options).result.initial.imu_noise;
}

void expect_noise_found_beside_sharp_pixels(std::uint64_t seed) {
  const ImuNoiseFactors found = found_beside_sharp_pixels(seed, 10.0);
  EXPECT_GE(found.gyro, 5.0);
  EXPECT_LE(found.gyro, 20.0);
  EXPECT_LE(found.accel, 20.0);  // three seconds hardly tell it
  const ImuNoiseFactors sound = found_beside_sharp_pixels(seed, 1.0);
  EXPECT_EQ(sound.gyro, 1.0);
  EXPECT_EQ(sound.accel, 1.0);
}

TEST(SensorStart, FindsTheNoiseOfAnImuBesidePixelsThatAreBetterThanAssumed) {
  expect_noise_found_beside_sharp_pixels(1);
}

TEST(FullSensorStart, FindsTheNoiseOfAnImuBesidePixelsThatAreBetterThanAssumed) {
  for (const std::uint64_t seed : {2, 3, 4}) {
    expect_noise_found_beside_sharp_pixels(seed);
  }
}

TEST(FullSensorStart, BelievesTheStatedNoiseOfAnImuWhereItIsToldTo) {
  const double nees = start_with_a_noisy_gyro(true).first;
  const auto [believed, ones] = start_with_a_noisy_gyro(false);
  EXPECT_GT(believed, 2.0 * nees);
  EXPECT_EQ(ones, std::vector<double>(ones.size(), 1.0));
}

/// What a rig at the origin sees that turns about its left camera: no way to know how far a point is.
Scene turning_scene(bool turns, std::uint64_t seed) {
  Scene scene = make_scene(of_seed(seed));
  scene.calibration.T_body_cam0.p.setZero();
  testing::Generator generator(4 + seed);
  const MountedRig rig = mount(scene.calibration);
  const auto rate = [turns](double t) {
    return turns ? Vector3d(0.1 * std::cos(3.0 * t), -0.2 * std::cos(2.0 * t), 0.3 * std::cos(t))
                 : Vector3d::Zero().eval();
  };
  NavigationState truth;
  scene.inputs.clear();
  scene.frames.clear();
  for (int ms = 0; ms <= 4500; ms += 5) {
    const double t = 1e-3 * ms;
    const Vector3d noise = testing::random_normal(generator, 3) * 1e-3 / std::sqrt(0.005);
    const Vector3d shake = testing::random_normal(generator, 3) * 1e-2 / std::sqrt(0.005);
    scene.inputs.push_back({ms * testing::kMs, rate(t) + noise,
                            truth.T_world_body.R.transpose() * Vector3d(0.0, 0.0, 9.81) + shake});
    if (ms % 50 == 0) {
      StereoFrame frame;
      frame.t_ns = ms * testing::kMs;
      for (std::size_t j = 0; j < scene.landmarks.size(); ++j) {
        const Vector3d X = truth.T_world_body.inverse() * scene.landmarks[j];
        const auto left = project(rig[0].camera, rig[0].T_cam_body * X);
        const auto right = project(rig[1].camera, rig[1].T_cam_body * X);
        if (left && right) {
          frame.observations.push_back({static_cast<std::int64_t>(j),
                                        left->uv + 0.5 * testing::random_normal(generator, 2),
                                        right->uv + 0.5 * testing::random_normal(generator, 2)});
        }
      }
      scene.frames.push_back(frame);
    }
    truth.T_world_body.R = truth.T_world_body.R * so3_exp(0.005 * rate(t + 0.0025));
  }
  return scene;
}

/// Error of the logarithm of the map's scale, as the points' covariance weighs it, over its sigma, squared.
double scale_nees(const InitialState& state, const Scene& scene) {
  const auto n = static_cast<Eigen::Index>(state.landmarks.size());
  VectorXd error(n), rho(n);
  MatrixXd C(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Landmark& landmark = state.landmarks[static_cast<std::size_t>(i)];
    rho[i] = landmark.value.z();
    error[i] = -std::log(rho[i] * scene.landmarks[static_cast<std::size_t>(landmark.track_id)].norm());
    for (Eigen::Index j = 0; j < n; ++j) {
      C(i, j) = state.landmarks_covariance(3 * i + 2, 3 * j + 2);
    }
  }
  C = rho.cwiseInverse().asDiagonal() * C * rho.cwiseInverse().asDiagonal();
  const VectorXd x = Cholesky(C).solve(VectorXd::Ones(n));
  return x.dot(error) * x.dot(error) / x.sum();
}

void expect_no_scale_learned(std::initializer_list<std::uint64_t> seeds) {
  StartOptions how;
  how.longest_s = how.longest_still_s = 4.0;
  for (const bool turns : {true, false}) {
    for (const std::uint64_t seed : seeds) {
      const Scene scene = turning_scene(turns, seed);
      const Started distrusting = start(scene, options_of(scene, Method::kLcekf), how);
      EXPECT_EQ(distrusting.report.status, StartStatus::kTimedOut);
      EXPECT_GE(distrusting.report.scale_sigma, 0.5);
      EXPECT_LE(scale_nees(distrusting.result.initial, scene), 4.0);
      EXPECT_NE(distrusting.report.missing.find("parallax"), std::string::npos);
    }
    const Scene scene = turning_scene(turns, 1);
    const Started trusting = start(scene, options_of(scene, Method::kEkf), how);
    EXPECT_LE(trusting.report.scale_sigma, 0.05);
  }
}

TEST(SensorStart, LearnsNoScaleFromTurningOrStandingWhereTheRigIsNotTrusted) { expect_no_scale_learned({1}); }

TEST(FullSensorStart, LearnsNoScaleFromTurningOrStandingWhereTheRigIsNotTrusted) {
  expect_no_scale_learned({2, 6});
}

}  // namespace
}  // namespace limber
