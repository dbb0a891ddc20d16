// SPDX-License-Identifier: MIT
// What a start owes to parameters beyond theta that are estimated: known with body and first map, so that a
// mount which is wrong by as much as it says is found later, and takes the poses with it.
#include <gtest/gtest.h>

#include <cmath>

#include "initialize/started.hpp"
#include "limber/core/angle.hpp"
#include "limber/core/so3.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/sensors/parameters.hpp"

namespace limber {
namespace {

using testing::at_once;
using testing::make_scene;
using testing::of_seed;
using testing::options_of;
using testing::Scene;
using testing::Started;

constexpr Eigen::Index kTurned = first_of(ParameterBlock::kMount);  // imu-ax

/// A scene whose calibration has the mount turned by the true one plus `error` degrees about the body's x.
Scene with_turned_mount(std::uint64_t seed, double error) {
  Scene scene = make_scene(of_seed(seed));
  scene.calibration = corrected(scene.calibration, error / kToDegrees * ParameterVector::Unit(kTurned));
  return scene;
}

NavigatorOptions estimating(const Scene& scene, double degrees) {
  NavigatorOptions options = options_of(scene, Method::kEkf);
  options.estimated.segment<3>(kTurned).setConstant(degrees / kToDegrees);
  return options;
}

Started started(const Scene& scene, const NavigatorOptions& options) {
  return testing::start(scene, options, at_once());
}

TEST(ParametersOfStart, AreNoneWhereNoneIsEstimated) {
  const Scene scene = make_scene(of_seed(31));
  EXPECT_EQ(started(scene, options_of(scene, Method::kEkf)).result.initial.by_parameters.size(), 0);
}

/// A start with the mount as it is, and one with a mount that is off: as far apart as the first says.
TEST(ParametersOfStart, SayWhatAnErrorDoes) {
  constexpr double kError = 0.2;  // deg
  const Scene scene = make_scene(of_seed(32)), wrong = with_turned_mount(32, -kError);
  const InitialState at = started(wrong, estimating(wrong, 0.3)).result.initial;
  const InitialState there = started(scene, options_of(scene, Method::kEkf)).result.initial;
  ASSERT_GT(at.by_parameters.size(), 0);
  const Eigen::VectorXd says = kError / kToDegrees * at.by_parameters.col(kTurned - kBlockSize);
  const Eigen::Vector3d turn = so3_log(at.nav.T_world_body.R.transpose() * there.nav.T_world_body.R);
  const Eigen::Vector3d bias = there.nav.bias_accel - at.nav.bias_accel;
  EXPECT_LT((turn - says.segment<3>(StateLayout::kAttitude)).norm(), 0.2 * turn.norm());
  EXPECT_LT((bias - says.segment<3>(StateLayout::kBiasAccel)).norm(), 0.2 * bias.norm() + 1e-3);
}

/// The joint covariance against the slow, obvious one: S times the parameters' covariance times its
/// transpose.
TEST(ParametersOfStart, AreInTheJointCovariance) {
  const Scene scene = make_scene(of_seed(33));
  const NavigatorOptions options = estimating(scene, 0.3);
  const InitialState initial = started(scene, options).result.initial;
  ASSERT_FALSE(initial.landmarks.empty());
  StateLayout layout{options.motion};
  layout.has_more.back() = true;
  const Eigen::Matrix<double, 6, 6> prior =
      (Eigen::Matrix<double, 6, 1>() << 1e-5, 2e-5, 3e-5, 1e-9, 1e-9, 1e-9).finished().asDiagonal();
  Estimate estimate(layout, initial.nav, initial.body_covariance, scene.calibration.theta,
                    Eigen::Matrix<double, 6, 6>::Identity());
  estimate.mutable_P().set_diagonal_block(layout.more(2), prior);
  place_first_map(estimate, initial, scene.calibration.T_body_cam0);
  const Eigen::MatrixXd before = estimate.P().dense();
  correlate_with_parameters(estimate, initial);
  const Eigen::MatrixXd after = estimate.P().dense();

  const Eigen::Index body = layout.body_size(), points = initial.by_parameters.rows() - body;
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(estimate.size(), 6);
  const auto of_mount = initial.by_parameters.rightCols<6>();
  S.topRows(body) = of_mount.topRows(body);
  S.middleRows<6>(estimate.size() - points - 6) = of_mount.topRows<6>();
  S.bottomRows(points) = of_mount.bottomRows(points);
  Eigen::MatrixXd expected = before + S * prior * S.transpose();
  expected.middleCols<6>(layout.more(2)) += S * prior;
  expected.middleRows<6>(layout.more(2)) += prior * S.transpose();
  EXPECT_LT((after - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
}

TEST(ParametersOfStart, MakeAStartAnotherThanOneWithoutThem) {
  const Scene scene = make_scene(of_seed(35));
  const NavigatorOptions with = estimating(scene, 0.3), without = options_of(scene, Method::kEkf);
  EXPECT_TRUE(same_start(with, scene.calibration, with, scene.calibration));
  EXPECT_FALSE(same_start(with, scene.calibration, without, scene.calibration));
}

TEST(ParametersOfStart, OfAnotherSizeAreRefused) {
  const Scene scene = make_scene(of_seed(34));
  const NavigatorOptions options = estimating(scene, 0.3);
  InitialState initial = started(scene, options).result.initial;
  initial.by_parameters.conservativeResize(initial.by_parameters.rows() - 1, Eigen::NoChange);
  EXPECT_THROW(Navigator(options, scene.calibration, initial), std::invalid_argument);
}

}  // namespace
}  // namespace limber
