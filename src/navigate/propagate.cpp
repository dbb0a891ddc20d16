// SPDX-License-Identifier: MIT
#include "propagate.hpp"

#include "limber/core/dense.hpp"

namespace limber::detail {

using Eigen::MatrixXd;
using Eigen::Vector3d;

namespace {

/// Body and linearised step of one step of odometry, whose samples are taken times 1 + scale.
Transition predict_scaled_odometry(Propagation& out, const InputStep& step, const Eigen::Vector2d& scale,
                                   const OdometryNoise& noise) {
  const Vector3d v = (1.0 + scale.x()) * step.linear, omega = (1.0 + scale.y()) * step.angular;
  const Eigen::Matrix<double, 6, 2> by_scale = odometry_scale_jacobian(out.nav, v, omega, step.dt) *
                                               (scale.array() + 1.0).inverse().matrix().asDiagonal();
  Transition part = predict_odometry(out.nav, v, omega, step.dt, noise);
  out.by_scale = part.Phi * out.by_scale + by_scale;
  return part;
}

}  // namespace

Propagation propagate(const NavigationState& nav, const std::vector<InputStep>& steps,
                      const NavigatorOptions& options, const OdometryNoise& odometry_noise,
                      const Eigen::Vector2d& odometry_scale, double usual_interval_s, const MoreNoise& more) {
  const Eigen::Index k = StateLayout{options.motion}.body_size();
  Propagation out{nav, {MatrixXd::Identity(k, k), MatrixXd::Zero(k, k)}, Vector3d::Zero()};
  const auto predict_step = [&](const InputStep& step) {
    switch (options.motion) {
      case MotionModel::kImu: {
        const ImuStep imu = imu_step(step, out.nav, options.imu_noise, options.gravity, more);
        return predict_imu(out.nav, imu.omega, imu.accel, step.dt, imu.noise, options.gravity);
      }
      case MotionModel::kOdometry:
        return predict_scaled_odometry(out, step, odometry_scale,
                                       odometry_step_noise(step, odometry_noise, usual_interval_s, more));
      case MotionModel::kConstantVelocity:
        break;
    }
    return predict_constant_velocity(out.nav, step.dt, options.constant_velocity_noise);
  };
  for (const InputStep& step : steps) {
    out.omega_input = step.angular;
    const Transition part = predict_step(step);
    out.whole.Phi = multiply(part.Phi, out.whole.Phi);
    out.whole.Q = congruence(part.Phi, out.whole.Q) + part.Q;
    out.nav.t_ns = step.t_end_ns;
  }
  return out;
}

}  // namespace limber::detail
