// SPDX-License-Identifier: MIT
#include "limber/navigate/navigator.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <functional>

#include "limber/core/angle.hpp"
#include "limber/navigate/method.hpp"
#include "scene.hpp"

namespace limber {
namespace {

using testing::make_scene;
using testing::Scene;
using testing::SceneOptions;

struct Flight {
  double rmse = 0.0;
  std::vector<Eigen::Vector3d> positions;
  std::vector<FrameReport> reports;
  std::size_t events_kept = 0;  // at the end
  RigParameters theta, theta_sigma = RigParameters::Zero();
};

Flight fly(const Scene& scene, Navigator& navigator) {
  Flight out;
  std::size_t next = 0;
  for (std::size_t k = 0; k < scene.frames.size(); ++k) {
    const StereoFrame& frame = scene.frames[k];
    while (next < scene.inputs.size() && scene.inputs[next].t_ns <= frame.t_ns) {
      const InputSample& sample = scene.inputs[next++];
      if (scene.options.motion == MotionModel::kImu) {
        navigator.add_imu({sample.t_ns, sample.angular, sample.linear});
      } else if (scene.options.motion == MotionModel::kOdometry) {
        navigator.add_odometry({sample.t_ns, sample.linear, sample.angular});
      }
    }
    out.reports.push_back(navigator.process(frame));
    const Estimate& estimate = navigator.estimate();
    out.positions.push_back(estimate.nav().T_world_body.p);
    out.rmse += (out.positions.back() - scene.truth[k].T_world_body.p).squaredNorm();
    EXPECT_EQ(estimate.nav().t_ns, frame.t_ns);
  }
  out.rmse = std::sqrt(out.rmse / static_cast<double>(scene.frames.size()));
  out.events_kept = navigator.events_kept();
  const Estimate& last = navigator.estimate();
  out.theta = last.theta();
  if (last.layout().has_theta) {
    out.theta_sigma = last.P().diagonal_block<6>(last.layout().theta()).diagonal().cwiseSqrt();
  }
  return out;
}

Flight fly(const Scene& scene, Method method) {
  NavigatorOptions options = scene.options;
  options.method = method;
  Navigator navigator(options, scene.calibration, scene.initial);
  return fly(scene, navigator);
}

SceneOptions ten_seconds(MotionModel motion = MotionModel::kImu) {
  SceneOptions options;
  options.motion = motion;
  options.duration_s = 10.0;
  return options;
}

RigParameters step_error() {
  RigParameters out;
  out << 0.003, -0.004, 0.005, 0.03, -0.003, 0.002;
  return out;
}

TEST(Navigator, ASoundRigIsNavigatedAsByTheEkf) {
  for (const MotionModel motion : {MotionModel::kImu, MotionModel::kOdometry}) {
    const Scene scene = make_scene(ten_seconds(motion));
    const Flight ekf = fly(scene, Method::kEkf), adaptive = fly(scene, Method::kAdaptive);
    EXPECT_NEAR(adaptive.rmse, ekf.rmse, 0.02 * ekf.rmse);
    EXPECT_EQ(adaptive.reports.back().health->verdict, HealthVerdict::kOk);
  }
}

TEST(Navigator, AStepIsLearnedAndDoesNotLeadAstray) {
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kOdometry, MotionModel::kConstantVelocity}) {
    SceneOptions options = ten_seconds(motion);
    options.theta_error = [](double t) {
      return t < 6.0 ? RigParameters(RigParameters::Zero()) : step_error();
    };
    const Scene scene = make_scene(options);
    const Flight sound = fly(make_scene(ten_seconds(motion)), Method::kEkf);
    const Flight ekf = fly(scene, Method::kEkf), adaptive = fly(scene, Method::kAdaptive);
    EXPECT_LT(adaptive.rmse, ekf.rmse) << static_cast<int>(motion);
    EXPECT_LT(adaptive.rmse, 1.3 * sound.rmse) << static_cast<int>(motion);
    if (motion == MotionModel::kConstantVelocity) {
      continue;  // it may have fallen back to the constrained filter, which estimates no theta
    }
    const RigParameters off = adaptive.theta - scene.theta_true.back();
    EXPECT_LT(off.cwiseQuotient(adaptive.theta_sigma).cwiseAbs().maxCoeff(), 4.0) << static_cast<int>(motion);
    EXPECT_LT(off.cwiseQuotient(plausible_error(scene.calibration.baseline())).norm(),
              step_error().cwiseQuotient(plausible_error(scene.calibration.baseline())).norm())
        << static_cast<int>(motion);
  }
}

TEST(Navigator, AnErrorFromTheStartIsFoundByTheParallelFilter) {
  SceneOptions options = ten_seconds();
  options.theta_error = [](double) { return RigParameters(0.1 * RigParameters::Unit(3) * 0.3); };
  const Scene scene = make_scene(options);
  const Flight ekf = fly(scene, Method::kEkf), lcekf = fly(scene, Method::kLcekf),
               adaptive = fly(scene, Method::kAdaptive);
  EXPECT_EQ(adaptive.reports.back().health->verdict, HealthVerdict::kDecalibrated);
  EXPECT_LT(adaptive.rmse, ekf.rmse);
  EXPECT_LT((adaptive.positions.back() - scene.truth.back().T_world_body.p).norm(),
            3.0 * (lcekf.positions.back() - scene.truth.back().T_world_body.p).norm() + 0.01);
}

/// Linearised where the assumed rig is, or one step away, it takes scale out of nothing and loses its map.
TEST(Navigator, TheConstrainedFilterIsAsGoodWhereTheRigIsFiveDegreesOff) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SceneOptions options = ten_seconds();
    options.seed = seed;
    const Flight sound = fly(make_scene(options), Method::kLcekf);
    options.theta_error = [](double) { return RigParameters(RigParameters::Unit(1) * 5.0 / kToDegrees); };
    const Flight bent = fly(make_scene(options), Method::kLcekf);
    EXPECT_LT(bent.rmse, 1.3 * sound.rmse) << seed;
  }
}

/// What nothing can learn must still not be believed against all evidence.
TEST(Navigator, WhereNothingFixesTheScaleAGrossErrorIsLeftToTheParallelFilter) {
  SceneOptions options = ten_seconds(MotionModel::kConstantVelocity);
  options.theta_error = [](double) { return RigParameters(RigParameters::Unit(1) * 5.0 / kToDegrees); };
  const Scene scene = make_scene(options);
  const Flight ekf = fly(scene, Method::kEkf), lcekf = fly(scene, Method::kLcekf),
               adaptive = fly(scene, Method::kAdaptive);
  EXPECT_GT(ekf.rmse, 3.0 * lcekf.rmse);
  EXPECT_LT(adaptive.rmse, 1.2 * lcekf.rmse);
  EXPECT_EQ(adaptive.events_kept, 0U);  // to go back to: nobody will
}

/// Its depths are wrong, and lengths with them, while hardly an innovation is.
TEST(Navigator, WhereNothingFixesTheScaleARigOfAnotherVergenceIsLeftToTheParallelFilter) {
  SceneOptions options = ten_seconds(MotionModel::kConstantVelocity);
  options.theta_error = [](double) { return RigParameters(0.01 * RigParameters::Unit(1)); };
  const Scene scene = make_scene(options);
  const Flight ekf = fly(scene, Method::kEkf), lcekf = fly(scene, Method::kLcekf),
               adaptive = fly(scene, Method::kAdaptive);
  EXPECT_GT(ekf.rmse, 3.0 * lcekf.rmse);
  EXPECT_LT(adaptive.rmse, 1.2 * lcekf.rmse);
}

TEST(Navigator, WhereNothingFixesTheScaleAWrongStartIsNavigatedAsByTheEkfAndReported) {
  SceneOptions options = ten_seconds(MotionModel::kConstantVelocity);
  options.theta_error = [](double) { return RigParameters(0.3 * step_error()); };
  const Scene scene = make_scene(options);
  const Flight ekf = fly(scene, Method::kEkf), adaptive = fly(scene, Method::kAdaptive);
  EXPECT_EQ(adaptive.reports.back().health->verdict, HealthVerdict::kDecalibrated);
  EXPECT_NEAR(adaptive.rmse, ekf.rmse, 0.02 * ekf.rmse);
}

TEST(Navigator, OtherMethodsAreLeftAlone) {
  const Scene scene = make_scene(SceneOptions{});
  NavigatorOptions options = scene.options;
  options.method = Method::kLcekf;
  StereoFilter plain(options, scene.calibration, scene.initial);
  Navigator supervised(options, scene.calibration, scene.initial);
  for (const InputSample& sample : scene.inputs) {
    plain.add_imu({sample.t_ns, sample.angular, sample.linear});
    supervised.add_imu({sample.t_ns, sample.angular, sample.linear});
  }
  for (const StereoFrame& frame : scene.frames) {
    (void)plain.process(frame);
    (void)supervised.process(frame);
    EXPECT_EQ(plain.estimate().nav().T_world_body.p, supervised.estimate().nav().T_world_body.p);
    EXPECT_EQ(plain.estimate().P().dense(), supervised.estimate().P().dense());
  }
}

TEST(Navigator, ResetBeginsAnewWithWhatItWasGiven) {
  const Scene scene = make_scene(testing::wrong_rig());
  NavigatorOptions adaptive = scene.options;
  adaptive.method = Method::kAdaptive;
  Navigator navigator(adaptive, scene.calibration, scene.initial);
  const Flight first = fly(scene, navigator);
  EXPECT_NE(navigator.calibration().theta, scene.calibration.theta);
  navigator.reset(scene.initial);
  EXPECT_EQ(navigator.calibration().theta, scene.calibration.theta);
  EXPECT_EQ(navigator.events_kept(), 0U);
  EXPECT_EQ(fly(scene, navigator).positions, first.positions);
}

}  // namespace
}  // namespace limber
