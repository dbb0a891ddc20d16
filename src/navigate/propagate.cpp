// SPDX-License-Identifier: MIT
#include "propagate.hpp"

#include <algorithm>
#include <cmath>

#include "limber/core/dense.hpp"

namespace limber::detail {

using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

/// Interpolated noise lasts as long as the gap, up to this many intervals.
constexpr double kLongestInterpolation = 100.0;

double with(double density, double gap, double variance) {
  return std::sqrt(density * density * std::min(gap, kLongestInterpolation) + variance);
}

Transition predict_step(NavigationState& nav, const InputStep& step, const NavigatorOptions& options,
                        const OdometryNoise& odometry_noise, double usual_interval_s, double more_angular,
                        double more_linear) {
  const double angular = step.angular_unknown.density + more_angular;
  const double linear = step.linear_unknown.density + more_linear;
  switch (options.motion) {
    case MotionModel::kImu: {
      ImuNoise noise = options.imu_noise;
      noise.gyro_density = with(noise.gyro_density, step.gap, angular);
      noise.accel_density = with(noise.accel_density, step.gap, linear);
      const double turn = step.angular_unknown.memory, force = step.linear_unknown.memory;
      if (turn == 1.0 && force == 1.0) {
        return predict_imu(nav, step.angular, step.linear, step.dt, noise, options.gravity);
      }
      const Vector3d at_rest =
          nav.T_world_body.R.transpose() * Vector3d(0.0, 0.0, options.gravity) + nav.bias_accel;
      return predict_imu(nav, turn * step.angular + (1.0 - turn) * nav.bias_gyro,
                         force * step.linear + (1.0 - force) * at_rest, step.dt, noise, options.gravity);
    }
    case MotionModel::kOdometry: {
      // Per-sample noise as it acts over a step of dt: white, so that its variance goes with the interval
      // over dt.
      const double share = std::min(step.gap, kLongestInterpolation) *
                           (usual_interval_s > 0.0 ? usual_interval_s / step.dt : 1.0);
      OdometryNoise noise = odometry_noise;
      noise.sigma_v = (share * noise.sigma_v.cwiseAbs2().array() + linear / step.dt).sqrt();
      noise.sigma_omega = (share * noise.sigma_omega.cwiseAbs2().array() + angular / step.dt).sqrt();
      return predict_odometry(nav, step.linear, step.angular, step.dt, noise);
    }
    case MotionModel::kConstantVelocity:
      break;
  }
  return predict_constant_velocity(nav, step.dt, options.constant_velocity_noise);
}

}  // namespace

Propagation propagate(const NavigationState& nav, const std::vector<InputStep>& steps,
                      const NavigatorOptions& options, const OdometryNoise& odometry_noise,
                      double usual_interval_s, double more_angular_density, double more_linear_density) {
  const Eigen::Index k = StateLayout{options.motion}.body_size();
  Propagation out{nav, {MatrixXd::Identity(k, k), MatrixXd::Zero(k, k)}, Vector3d::Zero()};
  for (const InputStep& step : steps) {
    out.omega_input = step.angular;
    const Transition part = predict_step(out.nav, step, options, odometry_noise, usual_interval_s,
                                         more_angular_density, more_linear_density);
    out.whole.Phi = multiply(part.Phi, out.whole.Phi);
    out.whole.Q = congruence(part.Phi, out.whole.Q) + part.Q;
    out.nav.t_ns = step.t_end_ns;
  }
  return out;
}

}  // namespace limber::detail
