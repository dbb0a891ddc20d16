// SPDX-License-Identifier: MIT
#include "limber/predict/input_noise.hpp"

#include <algorithm>
#include <cmath>

namespace limber {

using Eigen::Vector3d;

namespace {

/// Interpolated noise lasts as long as the gap, up to this many intervals.
constexpr double kLongestInterpolation = 100.0;

double with(double density, double gap, double variance) {
  return std::sqrt(density * density * std::min(gap, kLongestInterpolation) + variance);
}

}  // namespace

MoreNoise beside_stated(const ImuNoise& stated, const ImuNoiseFactors& factors) {
  const auto more = [](double factor, double density) { return (factor * factor - 1.0) * density * density; };
  return {more(factors.gyro, stated.gyro_density), more(factors.accel, stated.accel_density)};
}

ImuStep imu_step(const InputStep& step, const NavigationState& body, const ImuNoise& noise, double gravity,
                 const MoreNoise& more) {
  ImuStep out{step.angular, step.linear, noise};
  out.noise.gyro_density = with(noise.gyro_density, step.gap, step.angular_unknown.density + more.angular);
  out.noise.accel_density = with(noise.accel_density, step.gap, step.linear_unknown.density + more.linear);
  const double turn = step.angular_unknown.memory, force = step.linear_unknown.memory;
  if (turn != 1.0 || force != 1.0) {
    const Vector3d at_rest = body.T_world_body.R.transpose() * Vector3d(0.0, 0.0, gravity) + body.bias_accel;
    out.omega = turn * step.angular + (1.0 - turn) * body.bias_gyro;
    out.accel = force * step.linear + (1.0 - force) * at_rest;
  }
  return out;
}

OdometryNoise odometry_step_noise(const InputStep& step, const OdometryNoise& noise, double usual_interval_s,
                                  const MoreNoise& more) {
  const double share =
      std::min(step.gap, kLongestInterpolation) * (usual_interval_s > 0.0 ? usual_interval_s / step.dt : 1.0);
  const auto over_step = [&](const Vector3d& sigma, double density) -> Vector3d {
    return (share * sigma.cwiseAbs2().array() + density / step.dt).sqrt();
  };
  return {over_step(noise.sigma_v, step.linear_unknown.density + more.linear),
          over_step(noise.sigma_omega, step.angular_unknown.density + more.angular)};
}

}  // namespace limber
