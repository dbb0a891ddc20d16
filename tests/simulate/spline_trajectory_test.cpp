// SPDX-License-Identifier: MIT
#include "limber/simulate/spline_trajectory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <stdexcept>

#include "limber/core/so3.hpp"
#include "limber/simulate/simulator.hpp"
#include "random_geometry.hpp"
#include "source_folder.hpp"

namespace limber {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.81;

SplineTrajectory random_spline(double knot_spacing, double max_turn) {
  testing::Generator generator(1);
  std::vector<Pose> poses = {Pose{}};
  for (int i = 0; i < 12; ++i) {
    poses.push_back({poses.back().R * testing::random_rotation(generator, max_turn),
                     testing::random_vector(generator, 10.0)});
  }
  return {poses, knot_spacing};
}

/// Worst differences between the analytic derivatives and central differences over the whole trajectory.
struct DerivativeErrors {
  double velocity = 0.0, acceleration = 0.0, rate = 0.0;
};

DerivativeErrors derivative_errors(const SplineTrajectory& trajectory, double end) {
  constexpr double h = 1e-5;
  DerivativeErrors worst;
  for (double t = 0.01; t < end - 0.01; t += 0.0371) {
    const Kinematics before = trajectory.at(t - h), now = trajectory.at(t), after = trajectory.at(t + h);
    const Vector3d v = (after.T_world_body.p - before.T_world_body.p) / (2.0 * h);
    const Vector3d a = (after.v_world_body - before.v_world_body) / (2.0 * h);
    const Vector3d w = so3_log(before.T_world_body.R.transpose() * after.T_world_body.R) / (2.0 * h);
    worst.velocity = std::max(worst.velocity, (v - now.v_world_body).norm());
    worst.acceleration = std::max(worst.acceleration, (a - now.a_world_body).norm());
    worst.rate = std::max(worst.rate, (w - now.omega_body).norm());
  }
  return worst;
}

TEST(SplineTrajectory, HasTheDerivativesOfItsPose) {
  for (const double max_turn : {1e-8, 0.5, 2.5}) {
    const DerivativeErrors worst = derivative_errors(random_spline(1.5, max_turn), 15.0);
    EXPECT_LT(worst.velocity, 1e-7);
    EXPECT_LT(worst.acceleration, 2e-4);  // one-sided where the jerk jumps
    EXPECT_LT(worst.rate, 1e-6);
  }
}

TEST(SplineTrajectory, IsSmoothWhereSegmentsMeet) {
  const double spacing = 2.0;
  const SplineTrajectory trajectory = random_spline(spacing, 1.0);
  for (int k = 1; k < 10; ++k) {
    const Kinematics before = trajectory.at(std::nextafter(k * spacing, 0.0)),
                     after = trajectory.at(k * spacing);
    EXPECT_LT((before.T_world_body.p - after.T_world_body.p).norm(), 1e-12);
    EXPECT_LT((before.T_world_body.R - after.T_world_body.R).norm(), 1e-12);
    EXPECT_LT((before.v_world_body - after.v_world_body).norm(), 1e-12);
    EXPECT_LT((before.a_world_body - after.a_world_body).norm(), 1e-12);
    EXPECT_LT((before.omega_body - after.omega_body).norm(), 1e-12);
  }
}

TEST(SplineTrajectory, MovesStraightThroughEvenlySpacedControlPoses) {
  std::vector<Pose> poses;
  for (int i = -1; i < 6; ++i) {
    poses.push_back({so3_exp({0.0, 0.0, 0.2 * i}), {1.0 * i, 2.0 * i, 0.0}});
  }
  const Kinematics state = SplineTrajectory(poses, 0.5).at(1.1);
  EXPECT_LT((state.T_world_body.p - Vector3d(2.2, 4.4, 0.0)).norm(), 1e-12);
  EXPECT_LT((state.T_world_body.R - so3_exp({0.0, 0.0, 0.44})).norm(), 1e-12);
  EXPECT_LT((state.v_world_body - Vector3d(2.0, 4.0, 0.0)).norm(), 1e-12);
  EXPECT_LT(state.a_world_body.norm(), 1e-12);
  EXPECT_LT((state.omega_body - Vector3d(0.0, 0.0, 0.4)).norm(), 1e-12);
}

TEST(SplineTrajectory, IsDefinedFromZeroToItsDurationOnly) {
  const SplineTrajectory trajectory = random_spline(1.5, 0.5);
  EXPECT_DOUBLE_EQ(trajectory.duration(), 15.0);
  EXPECT_NO_THROW((void)trajectory.at(0.0));
  EXPECT_NO_THROW((void)trajectory.at(15.0));
  EXPECT_THROW((void)trajectory.at(-1e-9), std::invalid_argument);
  EXPECT_THROW((void)trajectory.at(15.0 + 1e-9), std::invalid_argument);
  EXPECT_THROW((void)trajectory.at(std::nan("")), std::invalid_argument);
}

TEST(SplineTrajectory, RefusesTooFewPosesAndSpacingsThatAreNotPositive) {
  EXPECT_THROW(SplineTrajectory(std::vector<Pose>(3), 1.0), std::invalid_argument);
  EXPECT_THROW(SplineTrajectory(std::vector<Pose>(4), 0.0), std::invalid_argument);
  EXPECT_THROW(SplineTrajectory(std::vector<Pose>(4), std::nan("")), std::invalid_argument);
  EXPECT_THROW(SplineTrajectory(std::vector<Pose>(4), 1.0, -0.1), std::invalid_argument);
  EXPECT_THROW(SplineTrajectory(std::vector<Pose>(4), 1.0, std::nan("")), std::invalid_argument);
}

TEST(SpecificForce, IsGravityUpwardsAtRestInAnyAttitude) {
  testing::Generator generator(2);
  Kinematics state;
  EXPECT_EQ(specific_force(state, kGravity), Vector3d(0.0, 0.0, kGravity));
  state.T_world_body.R = testing::random_rotation(generator);
  EXPECT_LT((state.T_world_body.R * specific_force(state, kGravity) - Vector3d(0.0, 0.0, kGravity)).norm(),
            1e-14);
}

/// Rate and specific force integrated by the midpoint rule from the true start: distance from the truth at
/// `end` [m].
double integrated_position_error(const SplineTrajectory& trajectory, double end, int steps) {
  Kinematics state = trajectory.at(0.0);
  const double dt = end / steps;
  for (int k = 0; k < steps; ++k) {
    const Kinematics truth = trajectory.at((k + 0.5) * dt);
    const Eigen::Matrix3d R_middle = state.T_world_body.R * so3_exp(0.5 * dt * truth.omega_body);
    const Vector3d a = R_middle * specific_force(truth, kGravity) - kGravity * Vector3d::UnitZ();
    state.T_world_body.p += dt * state.v_world_body + 0.5 * dt * dt * a;
    state.v_world_body += dt * a;
    state.T_world_body.R = state.T_world_body.R * so3_exp(dt * truth.omega_body);
  }
  return (state.T_world_body.p - trajectory.at(end).T_world_body.p).norm();
}

struct NamedTrajectory {
  const char* name;
  TrajectoryScenario trajectory;
};

void PrintTo(const NamedTrajectory& named, std::ostream* out) { *out << named.name; }

class EveryKindOfTrajectory : public ::testing::TestWithParam<NamedTrajectory> {
 protected:
  [[nodiscard]] static Scenario scenario() {
    Scenario s;
    s.duration = 20.0;
    s.trajectory = GetParam().trajectory;
    return s;
  }
};

TEST_P(EveryKindOfTrajectory, IsReproducedByIntegratingItsIdealImu) {
  const SplineTrajectory trajectory = make_trajectory(scenario(), 1);
  const double coarse = integrated_position_error(trajectory, 20.0, 20000);
  const double fine = integrated_position_error(trajectory, 20.0, 40000);
  EXPECT_LT(coarse, 1e-4);
  EXPECT_LT(fine, 0.3 * coarse);  // of second order: a quarter
}

TEST_P(EveryKindOfTrajectory, HasTheDerivativesOfItsPose) {
  const DerivativeErrors worst = derivative_errors(make_trajectory(scenario(), 1), 20.0);
  EXPECT_LT(worst.velocity, 1e-6);
  EXPECT_LT(worst.acceleration, 5e-4);
  EXPECT_LT(worst.rate, 1e-6);
}

TEST_P(EveryKindOfTrajectory, LastsAsLongAsTheScenario) {
  EXPECT_GT(make_trajectory(scenario(), 1).duration(), 20.0);
}

INSTANTIATE_TEST_SUITE_P(Scenarios, EveryKindOfTrajectory,
                         ::testing::Values(NamedTrajectory{"RandomSpline", RandomSplineTrajectory{}},
                                           NamedTrajectory{"FigureEight", FigureEightTrajectory{}},
                                           NamedTrajectory{"File", FileTrajectory{testing::source_folder() /
                                                                                      "scenarios/walk.tum",
                                                                                  0.5, 0.1}}),
                         [](const auto& kind) { return kind.param.name; });

TEST(RandomSplineTrajectory, NeverExceedsItsSpeedAndRateAndStaysInItsBox) {
  Scenario s;
  s.trajectory =
      RandomSplineTrajectory{.half_extent = {20.0, 5.0, 1.0}, .max_speed = 1.5, .max_angular_rate = 0.2};
  for (std::uint64_t run = 0; run < 20; ++run) {
    const SplineTrajectory trajectory = make_trajectory(s, 7, run);
    for (double t = 0.0; t <= s.duration; t += 0.1) {
      const Kinematics state = trajectory.at(t);
      ASSERT_LE(state.v_world_body.norm(), 1.5 + 1e-12);
      ASSERT_LE(state.omega_body.norm(), 0.2 + 1e-12);
      ASSERT_TRUE((state.T_world_body.p.array().abs() <= Eigen::Array3d(20.0, 5.0, 1.0)).all());
    }
  }
}

TEST(RandomSplineTrajectory, IsAnotherOneInEveryRunUnlessTheWorldIsToStayTheSame) {
  Scenario s;
  const auto start = [&s](std::uint64_t seed, std::uint64_t run) -> Vector3d {
    return make_trajectory(s, seed, run).at(5.0).T_world_body.p;
  };
  EXPECT_NE(start(1, 0), start(1, 1));
  s.same_world_in_all_runs = true;
  EXPECT_EQ(start(1, 0), start(1, 1));
  EXPECT_NE(start(1, 0), start(2, 0));
}

TEST(FigureEightTrajectory, KeepsItsSpeedAndLooksAlongThePath) {
  Scenario s;
  s.trajectory = FigureEightTrajectory{.height = 0.0, .tilt = 0.0};
  const SplineTrajectory trajectory = make_trajectory(s, 1);
  for (double t = 0.0; t <= s.duration; t += 0.05) {
    const Kinematics state = trajectory.at(t);
    const double speed = state.v_world_body.norm();
    ASSERT_GE(speed, 1.97);  // the spline rounds the path by a few millimetres
    ASSERT_LE(speed, 3.03);
    const Vector3d forward = state.T_world_body.R.col(2);  // body = cam0, which looks along z
    ASSERT_GT(forward.dot(state.v_world_body) / speed, std::cos(0.01));
  }
}

TEST(EveryMadeTrajectory, StandsStillForItsRest) {
  Scenario s;
  for (const TrajectoryScenario& kind : {TrajectoryScenario(RandomSplineTrajectory{.rest = 2.0}),
                                         TrajectoryScenario(FigureEightTrajectory{.rest = 2.0})}) {
    s.trajectory = kind;
    const SplineTrajectory trajectory = make_trajectory(s, 1);
    for (double t = 0.0; t <= 1.9; t += 0.1) {
      EXPECT_LT(trajectory.at(t).v_world_body.norm(), 1e-12);
      EXPECT_LT(trajectory.at(t).omega_body.norm(), 1e-12);
    }
    EXPECT_GT(trajectory.at(15.0).v_world_body.norm(), 0.1);
  }
}

TEST(EveryMadeTrajectory, SetsOffWhereItsRestIsOver) {
  Scenario s;
  for (const double rest : {0.5, 2.0, 7.0}) {
    for (const TrajectoryScenario& kind : {TrajectoryScenario(RandomSplineTrajectory{.rest = rest}),
                                           TrajectoryScenario(FigureEightTrajectory{.rest = rest})}) {
      s.trajectory = kind;
      const SplineTrajectory trajectory = make_trajectory(s, 1);
      EXPECT_LT(trajectory.at(rest - 0.1).v_world_body.norm(), 1e-12);
      EXPECT_GT(trajectory.at(rest + 1.0).v_world_body.norm(), 0.005);
    }
  }
}

}  // namespace
}  // namespace limber
