// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <functional>

#include "limber/core/chi_square.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "scene.hpp"

/// Does a method know how wrong it is? Twelve seeded runs of three seconds each.
namespace limber {
namespace {

using testing::make_scene;
using testing::pose_error;
using testing::run;
using testing::Scene;
using testing::scene_theta_error;
using testing::SceneOptions;
using testing::with_method;
using testing::wrong_rig;

/// What a run says of itself and what it did.
struct Judgement {
  double end_nees = 0.0, nis = 0.0, dof = 0.0, squared = 0.0;
};

Judgement judge(const Scene& scene, const NavigatorOptions& options) {
  Judgement out;
  run(scene, options, [&](StereoFilter& navigator, std::size_t k, const FrameReport& report) {
    const auto e = pose_error(navigator, scene.truth[k]);
    out.end_nees = e.dot(navigator.estimate().P().diagonal_block<6>(0).llt().solve(e));
    out.nis += report.nis;
    out.dof += static_cast<double>(report.dof);
    out.squared += e.head<3>().squaredNorm() / static_cast<double>(scene.frames.size());
  });
  return out;
}

constexpr int kSeeds = 12;

/// Sum over runs of seeds 1 to kSeeds. The pose errors at the end of the runs are independent.
Judgement judge_runs(const std::function<Scene(std::uint64_t)>& scene_of, Method method,
                     const std::string& constraints = "full") {
  Judgement sum;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Scene scene = scene_of(seed);
    NavigatorOptions options = with_method(scene, method);
    options.constraints = constraint_set_from_string(constraints);
    const Judgement one = judge(scene, options);
    sum.end_nees += one.end_nees;
    sum.nis += one.nis;
    sum.dof += one.dof;
    sum.squared += one.squared / kSeeds;
  }
  return sum;
}

/// NEES of 12 runs: chi-square with 72 degrees of freedom, 95 % one in a million on either side. NIS of some
/// 60 000 rows: 3 % are many standard deviations, and room for what is not linear.
void expect_consistent(const Judgement& sum) {
  EXPECT_GE(sum.end_nees, chi_square_quantile(1e-6, 6.0 * kSeeds));
  EXPECT_LE(sum.end_nees, chi_square_quantile(1.0 - 1e-6, 6.0 * kSeeds));
  EXPECT_NEAR(sum.nis / sum.dof, 1.0, 0.05);
}

Scene exact_rig(std::uint64_t seed) {
  SceneOptions options;
  options.seed = seed;
  return make_scene(options);
}

TEST(NavigatorStatistics, OnAnExactRigAllAreConsistentAndTrustIsWorthSomething) {
  const Judgement ekf = judge_runs(exact_rig, Method::kEkf);
  const Judgement lcekf = judge_runs(exact_rig, Method::kLcekf);
  const Judgement mono_left = judge_runs(exact_rig, Method::kMonoLeft);
  expect_consistent(ekf);
  expect_consistent(lcekf);
  expect_consistent(mono_left);
  EXPECT_LT(ekf.squared, lcekf.squared);
  EXPECT_LT(lcekf.squared, mono_left.squared);
}

TEST(NavigatorStatistics, WhoExpectsNoErrorOfTheRigIsAsGoodAsWhoTrustsIt) {
  double soft = 0.0, ekf = 0.0, nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Scene scene = exact_rig(seed);
    NavigatorOptions options = with_method(scene, Method::kSoft);
    options.theta_sigma.setConstant(1e-9);
    const Judgement one = judge(scene, options);
    soft += one.squared;
    nees += one.end_nees;
    ekf += judge(scene, with_method(scene, Method::kEkf)).squared;
  }
  EXPECT_LE(nees, chi_square_quantile(1.0 - 1e-6, 6.0 * kSeeds));
  EXPECT_NEAR(soft, ekf, 0.05 * ekf);  // within 1 %; a quarter worse where the frame's own rig is believed
}

TEST(NavigatorStatistics, OnAWrongRigTheConstrainedOneStaysConsistentAndTheEkfDoesNot) {
  const auto scene_of = [](std::uint64_t seed) { return make_scene(wrong_rig(seed)); };
  const Judgement lcekf = judge_runs(scene_of, Method::kLcekf);
  expect_consistent(lcekf);
  const Judgement ekf = judge_runs(scene_of, Method::kEkf);
  EXPECT_GT(ekf.end_nees, 3.0 * chi_square_quantile(1.0 - 1e-6, 6.0 * kSeeds));
  EXPECT_GT(ekf.squared, 2.0 * lcekf.squared);
}

TEST(NavigatorStatistics, ARigThatJumpsEveryFrameDoesNotHarmTheConstrainedOne) {
  const auto scene_of = [](std::uint64_t seed) {
    SceneOptions options = wrong_rig(seed);
    options.theta_error = [](double t) {
      return RigParameters(scene_theta_error() * (std::llround(t / 0.05) % 2 == 0 ? 1.0 : -1.0));
    };
    return make_scene(options);
  };
  expect_consistent(judge_runs(scene_of, Method::kLcekf));
}

TEST(NavigatorStatistics, ConstraintsOnRotationAloneHoldAgainstATurnedCamera) {
  const auto scene_of = [](std::uint64_t seed) {
    SceneOptions options = wrong_rig(seed);
    options.theta_error = [](double) {
      RigParameters error = scene_theta_error();
      error.tail<3>().setZero();
      return error;
    };
    return make_scene(options);
  };
  expect_consistent(judge_runs(scene_of, Method::kLcekf, "rotation"));
}

TEST(NavigatorStatistics, DroppedInputsAndFramesBetweenSamplesAreTakenIntoAccount) {
  const auto scene_of = [](std::uint64_t seed) {
    SceneOptions options;
    options.seed = seed;
    options.frame_offset_ms = 2;
    Scene scene = make_scene(options);
    std::erase_if(scene.inputs, [](const InputSample& s) {
      const std::int64_t ms = s.t_ns / testing::kMs;
      return ms % 600 >= 300 && ms % 600 <= 340;
    });
    return scene;
  };
  expect_consistent(judge_runs(scene_of, Method::kLcekf));
}

TEST(NavigatorStatistics, WithOdometryTheConstrainedOneIsConsistentOnAWrongRig) {
  const auto scene_of = [](std::uint64_t seed) {
    SceneOptions options = wrong_rig(seed);
    options.motion = MotionModel::kOdometry;
    return make_scene(options);
  };
  expect_consistent(judge_runs(scene_of, Method::kLcekf));
}

}  // namespace
}  // namespace limber
