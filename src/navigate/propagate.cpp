// SPDX-License-Identifier: MIT
#include "propagate.hpp"

#include "limber/core/dense.hpp"
#include "parameter_roles.hpp"

namespace limber::detail {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Transition predict_step(NavigationState& nav, const InputStep& step, const NavigatorOptions& options,
                        const OdometryNoise& odometry_noise, const ConstantVelocityNoise& motion_noise,
                        double usual_interval_s, const MoreNoise& more) {
  switch (options.motion) {
    case MotionModel::kImu: {
      const ImuStep imu = imu_step(step, nav, options.imu_noise, options.gravity, more);
      return predict_imu(nav, imu.omega, imu.accel, step.dt, imu.noise, options.gravity);
    }
    case MotionModel::kOdometry:
      return predict_odometry(nav, step.linear, step.angular, step.dt,
                              odometry_step_noise(step, odometry_noise, usual_interval_s, more));
    case MotionModel::kConstantVelocity:
      break;
  }
  return predict_constant_velocity(nav, step.dt, motion_noise);
}

/// What the body's error gains where samples were taken before they are stamped: the inputs then are what
/// they will be, as if biases were off by as much. The biases stay.
VectorXd late_by_a_second(const InputStep& step, const Transition& part) {
  VectorXd out = -part.Phi.middleCols<3>(StateLayout::kBiasGyro) * step.angular_slope -
                 part.Phi.middleCols<3>(StateLayout::kBiasAccel) * step.linear_slope;
  out.segment<6>(StateLayout::kBiasGyro).setZero();
  return out;
}

}  // namespace

Propagation propagate(const NavigationState& nav, const std::vector<InputStep>& steps,
                      const NavigatorOptions& options, const OdometryNoise& odometry_noise,
                      const ConstantVelocityNoise& motion_noise, double usual_interval_s,
                      const MoreNoise& more) {
  const Eigen::Index k = StateLayout{options.motion}.body_size();
  Propagation out{nav, {MatrixXd::Identity(k, k), MatrixXd::Zero(k, k)}, Vector3d::Zero(), VectorXd::Zero(k)};
  for (const InputStep& step : steps) {
    out.omega_input = step.angular;
    const Transition part =
        predict_step(out.nav, step, options, odometry_noise, motion_noise, usual_interval_s, more);
    if (options.motion == MotionModel::kImu && !estimates_time_offset(options)) {
      out.by_clock = part.Phi * out.by_clock + late_by_a_second(step, part);
    }
    out.whole.Phi = multiply(part.Phi, out.whole.Phi);
    out.whole.Q = congruence(part.Phi, out.whole.Q) + part.Q;
    out.nav.t_ns = step.t_end_ns;
  }
  return out;
}

}  // namespace limber::detail
