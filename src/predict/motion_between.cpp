// SPDX-License-Identifier: MIT
#include "limber/predict/motion_between.hpp"

#include <utility>

#include "limber/core/so3.hpp"
#include "limber/predict/input_noise.hpp"
#include "transition_sum.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using L = StateLayout;

namespace {

/// A bias walks at least that much between two frames [rad/s, m/s²]: one that never did would be coupled with
/// the next so tightly that rounding takes what the prior says of it.
constexpr double kLeastBiasWalk = 1e-6;

MotionError zero_error(MotionModel motion) {
  const Index n = StateLayout{motion}.body_size();
  return {Eigen::VectorXd::Zero(n), MatrixXd::Zero(n, n), MatrixXd::Zero(n, n)};
}

/// e = Log(predictedᵀ R_fromᵀ R_to) and its derivatives.
void write_attitude(const Matrix3d& predicted, const NavigationState& from, const NavigationState& to,
                    MotionError& out) {
  const Matrix3d turned = from.T_world_body.R.transpose() * to.T_world_body.R;
  const Vector3d error = so3_log(predicted.transpose() * turned);
  const Matrix3d J = so3_right_jacobian_inverse(error);
  out.error.segment<3>(L::kAttitude) = error;
  out.J_from.block<3, 3>(L::kAttitude, L::kAttitude) = -J * turned.transpose();
  out.J_to.block<3, 3>(L::kAttitude, L::kAttitude) = J;
}

/// The part of the first state that turned the prediction: predicted = ... Exp(phi), phi = Phi x.
void write_turned_prediction(const Vector3d& phi, const Matrix3d& J_phi, Index column, MotionError& out) {
  const Vector3d error = out.error.segment<3>(L::kAttitude);
  out.J_from.block<3, 3>(L::kAttitude, column) =
      -so3_right_jacobian_inverse(error) * so3_exp(error).transpose() * so3_right_jacobian(phi) * J_phi;
}

/// e = to − from.
void write_difference(const Vector3d& from, const Vector3d& to, Index at, MotionError& out) {
  out.error.segment<3>(at) = to - from;
  out.J_from.block<3, 3>(at, at) = -Matrix3d::Identity();
  out.J_to.block<3, 3>(at, at) = Matrix3d::Identity();
}

/// A vector of the world, seen from the first body, against what delta says.
void write_seen(const Matrix3d& R_world_from, const Vector3d& v_world, const Vector3d& predicted, Index at,
                MotionError& out) {
  const Vector3d seen = R_world_from.transpose() * v_world;
  out.error.segment<3>(at) = seen - predicted;
  out.J_from.block<3, 3>(at, L::kAttitude) = skew(seen);
  out.J_from.block<3, 3>(at, at) = -R_world_from.transpose();
  out.J_to.block<3, 3>(at, at) = R_world_from.transpose();
}

MotionError imu_error(const MotionBetween& b, const NavigationState& from, const NavigationState& to,
                      double gravity) {
  MotionError out = zero_error(b.motion);
  const Vector3d fall = Vector3d(0.0, 0.0, -gravity) * b.dt;  // velocity gained [m/s]
  const Vector3d d_gyro = from.bias_gyro - b.delta.bias_gyro;
  const Vector3d d_accel = from.bias_accel - b.delta.bias_accel;
  const auto corrected = [&](const Vector3d& value, Index row) -> Vector3d {
    return value + b.Phi.block<3, 3>(row, L::kBiasGyro) * d_gyro +
           b.Phi.block<3, 3>(row, L::kBiasAccel) * d_accel;
  };
  const Matrix3d& R = from.T_world_body.R;
  write_seen(R, to.T_world_body.p - from.T_world_body.p - b.dt * (from.v_world_body + 0.5 * fall),
             corrected(b.delta.T_world_body.p, L::kPosition), L::kPosition, out);
  write_seen(R, to.v_world_body - from.v_world_body - fall, corrected(b.delta.v_world_body, L::kVelocity),
             L::kVelocity, out);
  out.J_from.block<3, 3>(L::kPosition, L::kVelocity) = -b.dt * R.transpose();
  const Matrix3d J_phi = b.Phi.block<3, 3>(L::kAttitude, L::kBiasGyro);
  const Vector3d phi = J_phi * d_gyro;
  write_attitude(b.delta.T_world_body.R * so3_exp(phi), from, to, out);
  write_turned_prediction(phi, J_phi, L::kBiasGyro, out);
  for (const Index row : {L::kPosition, L::kVelocity}) {
    out.J_from.block<3, 6>(row, L::kBiasGyro) = -b.Phi.block<3, 6>(row, L::kBiasGyro);
  }
  write_difference(from.bias_gyro, to.bias_gyro, L::kBiasGyro, out);
  write_difference(from.bias_accel, to.bias_accel, L::kBiasAccel, out);
  return out;
}

MotionError odometry_error(const MotionBetween& b, const NavigationState& from, const NavigationState& to) {
  MotionError out = zero_error(b.motion);
  write_seen(from.T_world_body.R, to.T_world_body.p - from.T_world_body.p, b.delta.T_world_body.p,
             L::kPosition, out);
  write_attitude(b.delta.T_world_body.R, from, to, out);
  return out;
}

MotionError constant_velocity_error(const MotionBetween& b, const NavigationState& from,
                                    const NavigationState& to) {
  MotionError out = zero_error(b.motion);
  write_difference(from.T_world_body.p + b.dt * from.v_world_body, to.T_world_body.p, L::kPosition, out);
  out.J_from.block<3, 3>(L::kPosition, L::kVelocity) = -b.dt * Matrix3d::Identity();
  const Vector3d turn = b.dt * from.omega_body;
  write_attitude(so3_exp(turn), from, to, out);
  write_turned_prediction(turn, b.dt * Matrix3d::Identity(), L::kRate, out);
  write_difference(from.v_world_body, to.v_world_body, L::kVelocity, out);
  write_difference(from.omega_body, to.omega_body, L::kRate, out);
  return out;
}

/// One step of delta, without gravity.
Transition advance(NavigationState& delta, const NavigationState& from, MotionModel motion,
                   const InputStep& step, const MotionNoise& noise, double sample_interval_s,
                   double gravity) {
  if (motion == MotionModel::kOdometry) {
    return predict_odometry(delta, step.linear, step.angular, step.dt,
                            odometry_step_noise(step, noise.odometry, sample_interval_s));
  }
  NavigationState body = delta;
  body.T_world_body.R = from.T_world_body.R * delta.T_world_body.R;
  const ImuStep imu = imu_step(step, body, noise.imu, gravity);
  return predict_imu(delta, imu.omega, imu.accel, step.dt, imu.noise, 0.0);
}

}  // namespace

MotionBetween motion_between(MotionModel motion, double dt, std::span<const InputStep> inputs,
                             const NavigationState& from, const MotionNoise& noise, double sample_interval_s,
                             double gravity) {
  const Index n = StateLayout{motion}.body_size();
  MotionBetween out{motion, dt, {}, MatrixXd::Identity(n, n), MatrixXd::Zero(n, n)};
  out.delta.bias_gyro = from.bias_gyro;
  out.delta.bias_accel = from.bias_accel;
  if (motion == MotionModel::kConstantVelocity) {
    out.Q = predict_constant_velocity(out.delta, dt, noise.constant_velocity).Q;
    return out;
  }
  detail::TransitionSum sum(n);
  for (const InputStep& step : inputs) {
    sum.add(advance(out.delta, from, motion, step, noise, sample_interval_s, gravity));
  }
  Transition whole = sum.sum();
  out.Phi = std::move(whole.Phi);
  out.Q = std::move(whole.Q);
  if (motion == MotionModel::kImu) {
    out.Q.diagonal().tail<6>().array() += kLeastBiasWalk * kLeastBiasWalk;
  }
  return out;
}

MotionError motion_error(const MotionBetween& between, const NavigationState& from, const NavigationState& to,
                         double gravity) {
  switch (between.motion) {
    case MotionModel::kImu:
      return imu_error(between, from, to, gravity);
    case MotionModel::kOdometry:
      return odometry_error(between, from, to);
    case MotionModel::kConstantVelocity:
      break;
  }
  return constant_velocity_error(between, from, to);
}

}  // namespace limber
