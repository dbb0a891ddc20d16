// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "scene.hpp"
#include "state/small_map.hpp"

/// Whole small runs of every method: exactness without noise, sameness, symmetries.
namespace limber {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using testing::make_scene;
using testing::pose_error;
using testing::run;
using testing::Scene;
using testing::scene_theta_error;
using testing::SceneOptions;
using testing::snapshot;
using testing::with_method;
using testing::wrong_rig;

constexpr LandmarkKind kKinds[] = {LandmarkKind::kInverseDepth, LandmarkKind::kCartesian};

std::string name(Method method, LandmarkKind kind) {
  return to_string(method) + (kind == LandmarkKind::kCartesian ? ", Cartesian" : ", inverse depth");
}

/// Depths of points that only the left camera sees start from a prior, not from the truth.
Scene stereo_points_only(Scene scene) {
  for (StereoFrame& frame : scene.frames) {
    std::erase_if(frame.observations, [](const StereoObservation& o) { return !o.in_cam0 || !o.in_cam1; });
  }
  return scene;
}

TEST(NavigatorRun, WithoutNoiseItKeepsTheTruth) {
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    SceneOptions options;
    options.noise = false;
    options.motion = motion;
    options.duration_s = 1.5;
    options.points = 40;
    const Scene scene = stereo_points_only(make_scene(options));
    for (const Method method : kAllMethods) {
      for (const LandmarkKind kind : kKinds) {
        if (method == Method::kMonoLeft) {
          continue;
        }
        double worst = 0.0;
        std::size_t used = 0;
        run(scene, with_method(scene, method, kind),
            [&](StereoFilter& navigator, std::size_t k, const FrameReport& r) {
              worst = std::max(worst, pose_error(navigator, scene.truth[k]).norm());
              used += r.used;
            });
        EXPECT_LE(worst, 1e-7) << name(method, kind);
        EXPECT_GE(used, 300U) << name(method, kind);
      }
    }
  }
}

TEST(NavigatorRun, CovarianceStaysPositiveDefinite) {
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    SceneOptions options;
    options.motion = motion;
    options.duration_s = 2.0;
    options.points = 40;
    options.theta_error = [](double) { return scene_theta_error(); };
    const Scene scene = make_scene(options);
    for (const Method method : kAllMethods) {
      for (const LandmarkKind kind : kKinds) {
        run(scene, with_method(scene, method, kind),
            [&](StereoFilter& navigator, std::size_t k, const FrameReport& r) {
              const MatrixXd P = testing::awake_covariance(navigator.estimate());
              ASSERT_TRUE(P == P.transpose());
              ASSERT_TRUE(Cholesky(P).succeeded()) << name(method, kind) << ", frame " << k;
              ASSERT_NE(r.status, UpdateStatus::kSingularInnovation) << name(method, kind) << ", frame " << k;
            });
      }
    }
  }
}

TEST(NavigatorRun, WithoutNoiseTheOracleKeepsTheTruthOnARigThatBends) {
  SceneOptions options;
  options.noise = false;
  options.theta_error = [](double t) { return RigParameters(scene_theta_error() * std::sin(5.0 * t)); };
  const Scene scene = stereo_points_only(make_scene(options));
  double worst = 0.0;
  run(
      scene, with_method(scene, Method::kOracle),
      [&](StereoFilter& navigator, std::size_t k, const FrameReport&) {
        worst = std::max(worst, pose_error(navigator, scene.truth[k]).norm());
        EXPECT_EQ(navigator.estimate().theta(), scene.theta_true[k]);
      },
      [&](StereoFilter& navigator, std::size_t k) {
        navigator.show_true_rig({0, scene.theta_true[k]});
      });
  EXPECT_LE(worst, 1e-7);
}

/// Everything a run leaves: the final state, bit by bit.
testing::Snapshot outcome(const Scene& scene, const NavigatorOptions& options) {
  testing::Snapshot out;
  run(scene, options, [&](StereoFilter& navigator, std::size_t k, const FrameReport&) {
    if (k + 1 == scene.frames.size()) {
      out = snapshot(navigator.estimate());
    }
  });
  return out;
}

TEST(NavigatorRun, RepeatsItselfBitByBit) {
  const Scene scene = make_scene(wrong_rig());
  for (const Method method : kAllMethods) {
    EXPECT_TRUE(outcome(scene, with_method(scene, method)) == outcome(scene, with_method(scene, method)))
        << to_string(method);
  }
}

TEST(NavigatorRun, MonoLeftDoesNotLookThroughTheRightCamera) {
  const Scene scene = make_scene(wrong_rig());
  Scene scrambled = scene;
  testing::Generator generator(1);
  for (StereoFrame& frame : scrambled.frames) {
    for (StereoObservation& o : frame.observations) {
      o.in_cam1 = testing::random_scalar(generator, 0.0, 1.0) < 0.5;
      o.uv_cam1 << testing::random_scalar(generator, 0.0, 750.0),
          testing::random_scalar(generator, 0.0, 480.0);
    }
  }
  scrambled.calibration.cam1.fu *= 2.0;
  EXPECT_TRUE(outcome(scene, with_method(scene, Method::kMonoLeft)) ==
              outcome(scrambled, with_method(scene, Method::kMonoLeft)));
  EXPECT_FALSE(outcome(scene, with_method(scene, Method::kEkf)) ==
               outcome(scrambled, with_method(scene, Method::kEkf)));
}

TEST(NavigatorRun, LcekfWithoutConstraintsIsTheEkf) {
  const Scene scene = make_scene(wrong_rig());
  for (const LandmarkKind kind : kKinds) {
    NavigatorOptions none = with_method(scene, Method::kLcekf, kind);
    none.constraints = constraint_set_from_string("none");
    EXPECT_TRUE(outcome(scene, none) == outcome(scene, with_method(scene, Method::kEkf, kind)));
    EXPECT_FALSE(outcome(scene, with_method(scene, Method::kLcekf, kind)) ==
                 outcome(scene, with_method(scene, Method::kEkf, kind)));
  }
}

/// A filter that carries theta's uncertainty `sigma` along, correlated with the pose, and leaves both as they
/// are.
void expect_considered(const Scene& scene, const NavigatorOptions& options, const RigParameters& sigma) {
  const Eigen::Index at = 15;
  const Eigen::Matrix<double, 6, 6> P_theta = sigma.cwiseAbs2().asDiagonal();
  double correlation = 0.0;
  run(scene, options, [&](StereoFilter& navigator, std::size_t, const FrameReport&) {
    const Estimate& estimate = navigator.estimate();
    EXPECT_EQ(estimate.theta(), scene.calibration.theta);
    EXPECT_LE((estimate.P().diagonal_block<6>(at) - P_theta).cwiseAbs().maxCoeff(), 1e-18);
    correlation = estimate.P().block(0, at, 6, 6).cwiseAbs().maxCoeff();
  });
  EXPECT_GT(correlation, 0.0);
}

TEST(NavigatorRun, ConsiderNeverMovesTheta) {
  const Scene scene = make_scene(wrong_rig());
  expect_considered(scene, with_method(scene, Method::kConsider),
                    plausible_error(scene.calibration.baseline()));
}

TEST(NavigatorRun, EkfConsidersWhatLensesLeaveOfPixelsThatItHasToLearn) {
  const Scene scene = make_scene({});
  NavigatorOptions options = with_method(scene, Method::kEkf);
  run(scene, options, [](StereoFilter& navigator, std::size_t, const FrameReport&) {
    EXPECT_FALSE(navigator.estimate().layout().has_theta);
  });
  options.learn_pixel_noise = true;
  expect_considered(scene, options, 0.03 * plausible_error(scene.calibration.baseline()));
}

TEST(NavigatorRun, EkfFullFindsAConstantError) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SceneOptions options;
    options.seed = seed;
    const RigParameters error = 0.3 * scene_theta_error();
    options.theta_error = [&](double) { return error; };
    const Scene scene = make_scene(options);
    NavigatorOptions full = with_method(scene, Method::kEkfFull);
    full.theta_walk = RigParameters::Constant(1e-10);
    run(scene, full, [&](StereoFilter& navigator, std::size_t k, const FrameReport&) {
      if (k + 1 < scene.frames.size()) {
        return;
      }
      const Eigen::Matrix<double, 6, 6> P = navigator.estimate().P().diagonal_block<6>(15);
      const RigParameters left = scene.theta_true[k] - navigator.estimate().theta();
      EXPECT_LE(left.dot(Cholesky(P).solve(left)), chi_square_quantile(1.0 - 1e-6, 6.0));
      EXPECT_LE(left.head<3>().norm(), 0.2 * error.head<3>().norm());
      // Ten times more certain than at the start of how the cameras look at each other.
      const RigParameters start = plausible_error(scene.calibration.baseline());
      EXPECT_LE(std::sqrt(P(0, 0)), 0.1 * start(0));
    });
  }
}

/// A diffuse Cartesian initialisation subtracts covariances of (1000 m)² and leaves square centimetres: of
/// sixteen digits six are left.
double rounding(LandmarkKind kind) { return kind == LandmarkKind::kCartesian ? 1e-5 : 1e-10; }

/// The world turned about the vertical and moved: the same noise, the same answer, turned and moved.
TEST(NavigatorRun, TurningTheWorldTurnsTheAnswer) {
  for (const MotionModel motion :
       {MotionModel::kImu, MotionModel::kConstantVelocity, MotionModel::kOdometry}) {
    SceneOptions options = wrong_rig();
    options.motion = motion;
    options.duration_s = 1.5;
    options.points = 40;
    const Scene scene = make_scene(options);
    options.yaw = 2.0;
    options.shift << 30.0, -20.0, 5.0;
    const Scene turned = make_scene(options);
    const Pose T_turned_world{so3_exp(Vector3d(0.0, 0.0, options.yaw)), options.shift};
    for (const Method method : kAllMethods) {
      for (const LandmarkKind kind : kKinds) {
        std::vector<Pose> poses;
        std::vector<Eigen::Matrix3d> covariances;
        run(scene, with_method(scene, method, kind), [&](StereoFilter& n, std::size_t, const FrameReport&) {
          poses.push_back(n.estimate().nav().T_world_body);
          covariances.push_back(n.estimate().P().diagonal_block<3>(0));
        });
        double worst = 0.0;
        run(turned, with_method(turned, method, kind),
            [&](StereoFilter& n, std::size_t k, const FrameReport&) {
              const Pose expected = T_turned_world * poses[k];
              const Pose& found = n.estimate().nav().T_world_body;
              const Eigen::Matrix3d P = T_turned_world.R * covariances[k] * T_turned_world.R.transpose();
              worst = std::max({worst, (found.p - expected.p).norm(), (found.R - expected.R).norm(),
                                (n.estimate().P().diagonal_block<3>(0) - P).norm() / P.norm()});
            });
        EXPECT_LE(worst, rounding(kind)) << name(method, kind);
      }
    }
  }
}

}  // namespace
}  // namespace limber
