// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "limber/core/errors.hpp"
#include "limber/core/random.hpp"
#include "limber/core/so3.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/measure/rig.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/simulator.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What a trajectory is made from, whatever its kind.
struct Recipe {
  double duration;          ///< [s]
  Matrix3d R_vehicle_body;  ///< vehicle: x forward, y left, z up
  RandomStream random;
};

/// Enough control poses that the spline outlasts the duration.
std::size_t control_count(double duration, double knot_spacing) {
  return static_cast<std::size_t>(duration / knot_spacing) + 4;
}

/// Control pose i sits there [s].
double control_time(std::size_t i, double knot_spacing) {
  return (static_cast<double>(i) - 1.0) * knot_spacing;
}

/// The vehicle frame in which the left camera looks along x.
Matrix3d vehicle_from_body(const RigScenario& rig) {
  Matrix3d R_vehicle_cam0;
  R_vehicle_cam0 << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  const StereoCalibration nominal{rig.cam0, rig.cam1, rig.theta, rig.body, rig.T_imu_cam0};
  return R_vehicle_cam0 * body_from_cam0(nominal).R.transpose();
}

Vector3d limited(const Vector3d& step, double longest) {
  const double length = step.norm();
  return length > longest ? Vector3d(step * (longest / length)) : step;
}

SplineTrajectory make(const RandomSplineTrajectory& t, const Recipe& recipe) {
  const std::size_t resting = t.rest > 0.0 ? 2 : 0;  // control poses that are as the first one
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < resting + control_count(recipe.duration, t.knot_spacing); ++i) {
    const auto symmetric = [&](std::uint32_t j) -> Vector3d {
      return 2.0 * recipe.random.uniform3(i, j) - Vector3d::Ones();
    };
    const Vector3d angles = symmetric(1).cwiseProduct(t.max_angles);
    Pose pose{rotation_from_euler_zyx(angles), symmetric(0).cwiseProduct(t.half_extent)};
    if (!poses.empty()) {
      const Pose& last = poses.back();
      const double step_limit = i <= resting ? 0.0 : t.knot_spacing;
      pose.p = last.p + limited(pose.p - last.p, t.max_speed * step_limit);
      pose.R =
          last.R * so3_exp(limited(so3_log(last.R.transpose() * pose.R), t.max_angular_rate * step_limit));
    }
    poses.push_back(pose);
  }
  for (Pose& pose : poses) {
    pose.R = so3_normalized(pose.R * recipe.R_vehicle_body);
  }
  return {std::move(poses), t.knot_spacing, t.rest};
}

/// The vehicle on the figure-eight where its parameter is s (0 and pi: the crossing, pi/2 and 3 pi/2: the
/// ends).
Pose pose_on_eight(const FigureEightTrajectory& t, double s) {
  const double sine = std::sin(s), cosine = std::cos(s);
  const double scale = t.half_length / (1.0 + cosine * cosine);
  const double yaw =
      std::atan2(3.0 * cosine * cosine - 1.0, cosine * (3.0 - cosine * cosine));  // of the tangent
  const Vector3d angles(t.tilt * std::sin(2.0 * s), t.tilt * cosine, yaw);
  return {rotation_from_euler_zyx(angles), {scale * sine, scale * sine * cosine, t.height * sine}};
}

/// ds/dt at time `since_rest` after setting off: fastest at the crossing, slowest at both ends.
double eight_rate(const FigureEightTrajectory& t, double s, double since_rest) {
  constexpr double kGatheringSpeed = 2.0;  // [s]
  const double mean = 0.5 * (t.max_speed + t.min_speed);
  const double speed = mean + 0.5 * (t.max_speed - t.min_speed) * std::cos(2.0 * s);
  const double u = t.rest > 0.0 ? std::clamp(since_rest / kGatheringSpeed, 0.0, 1.0) : 1.0;
  const double start = u * u * (3.0 - 2.0 * u);
  return start * speed * std::sqrt(1.0 + std::cos(s) * std::cos(s)) / t.half_length;
}

SplineTrajectory make(const FigureEightTrajectory& t, const Recipe& recipe) {
  constexpr double kKnotSpacing = 0.1;  // [s]
  constexpr int kSubsteps = 20;
  constexpr double kStep = kKnotSpacing / kSubsteps;
  double s = 2.0 * std::numbers::pi * recipe.random.uniform(0);  // sets off anywhere on the eight
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < control_count(recipe.duration, kKnotSpacing); ++i) {
    Pose pose = pose_on_eight(t, s);
    pose.R = pose.R * recipe.R_vehicle_body;
    poses.push_back(pose);
    for (int k = 0; k < kSubsteps; ++k) {  // midpoint rule
      const double since_rest = control_time(i, kKnotSpacing) + k * kStep - t.rest;
      const double s_middle = s + 0.5 * kStep * eight_rate(t, s, since_rest);
      s += kStep * eight_rate(t, s_middle, since_rest + 0.5 * kStep);
    }
  }
  return {std::move(poses), kKnotSpacing};
}

SplineTrajectory make(const FileTrajectory& t, const Recipe& recipe) {
  const std::vector<StampedPose> file = read_tum(t.path);
  const std::int64_t start_ns = file.front().t_ns;
  const double available = static_cast<double>(file.back().t_ns - start_ns) / 1e9;
  if (t.start + recipe.duration > available) {
    throw DataError(t.path.string(), 0, fmt::format("poses over {:.9g} s", t.start + recipe.duration),
                    fmt::format("{:.9g} s", available));
  }
  std::vector<GroundTruthState> states;
  for (const StampedPose& pose : file) {
    states.push_back({.t_ns = pose.t_ns - start_ns,
                      .R_world_body = pose.T_world_body.R,
                      .p_world_body = pose.T_world_body.p});
  }
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < control_count(recipe.duration, t.knot_spacing); ++i) {
    const double time = std::clamp(t.start + control_time(i, t.knot_spacing), 0.0, available);
    const auto state = groundtruth_at(states, std::llround(time * 1e9), states.back().t_ns);
    poses.push_back({so3_normalized(state->R_world_body), state->p_world_body});
  }
  return {std::move(poses), t.knot_spacing};
}

}  // namespace

SplineTrajectory make_trajectory(const Scenario& scenario, std::uint64_t seed, std::uint64_t run) {
  check_scenario(scenario);
  const Recipe recipe{scenario.duration, vehicle_from_body(scenario.rig),
                      RandomStream(seed, scenario.same_world_in_all_runs ? 0 : run, "trajectory")};
  return std::visit([&recipe](const auto& kind) { return make(kind, recipe); }, scenario.trajectory);
}

}  // namespace limber
