// SPDX-License-Identifier: MIT
#include "limber/predict/motion.hpp"

#include "limber/core/so3.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using L = StateLayout;

namespace {

/// Adds the noise of a doubly integrated white acceleration (density [unit/s²/√Hz]) to the blocks of a
/// position-like and a velocity-like triplet; J turns the acceleration into their frame.
void add_integrated_noise(MatrixXd& Q, Index position, Index velocity, double density, double dt) {
  const double q = density * density;
  const Matrix3d I = Matrix3d::Identity();
  Q.block<3, 3>(position, position) += I * (q * dt * dt * dt / 3.0);
  Q.block<3, 3>(position, velocity) += I * (q * dt * dt / 2.0);
  Q.block<3, 3>(velocity, position) += I * (q * dt * dt / 2.0);
  Q.block<3, 3>(velocity, velocity) += I * (q * dt);
}

}  // namespace

Transition predict_imu(NavigationState& state, const Vector3d& omega_imu, const Vector3d& accel_imu,
                       double dt, const ImuNoise& noise, double gravity) {
  const Vector3d omega = omega_imu - state.bias_gyro;
  const Vector3d accel = accel_imu - state.bias_accel;
  const Vector3d turn = omega * dt;
  const Matrix3d half = so3_exp(0.5 * turn);
  const Matrix3d R = state.T_world_body.R;
  const Matrix3d R_mid = R * half;
  const Vector3d accel_world = R_mid * accel - Vector3d(0.0, 0.0, gravity);

  Transition step{MatrixXd::Identity(15, 15), MatrixXd::Zero(15, 15)};
  MatrixXd& Phi = step.Phi;
  const Matrix3d J_a_theta = -R * skew(half * accel);  // d(R_mid a) / d(dtheta)
  const Matrix3d J_a_omega = -R_mid * skew(accel) * so3_right_jacobian(0.5 * turn) * (0.5 * dt);
  Phi.block<3, 3>(L::kPosition, L::kVelocity) = Matrix3d::Identity() * dt;
  Phi.block<3, 3>(L::kPosition, L::kAttitude) = 0.5 * dt * dt * J_a_theta;
  Phi.block<3, 3>(L::kPosition, L::kBiasGyro) = -0.5 * dt * dt * J_a_omega;
  Phi.block<3, 3>(L::kPosition, L::kBiasAccel) = -0.5 * dt * dt * R_mid;
  Phi.block<3, 3>(L::kAttitude, L::kAttitude) = so3_exp(-turn);
  Phi.block<3, 3>(L::kAttitude, L::kBiasGyro) = -so3_right_jacobian(turn) * dt;
  Phi.block<3, 3>(L::kVelocity, L::kAttitude) = dt * J_a_theta;
  Phi.block<3, 3>(L::kVelocity, L::kBiasGyro) = -dt * J_a_omega;
  Phi.block<3, 3>(L::kVelocity, L::kBiasAccel) = -dt * R_mid;

  MatrixXd& Q = step.Q;
  add_integrated_noise(Q, L::kPosition, L::kVelocity, noise.accel_density, dt);
  Q.block<3, 3>(L::kAttitude, L::kAttitude) +=
      Matrix3d::Identity() * (noise.gyro_density * noise.gyro_density * dt);
  Q.block<3, 3>(L::kBiasGyro, L::kBiasGyro) +=
      Matrix3d::Identity() * (noise.gyro_walk * noise.gyro_walk * dt);
  Q.block<3, 3>(L::kBiasAccel, L::kBiasAccel) +=
      Matrix3d::Identity() * (noise.accel_walk * noise.accel_walk * dt);

  // Eq. (34), with the attitude at the middle of the step.
  state.T_world_body.p += state.v_world_body * dt + 0.5 * dt * dt * accel_world;
  state.v_world_body += accel_world * dt;
  state.T_world_body.R = so3_normalized(R * so3_exp(turn));
  state.omega_body = omega;
  return step;
}

Transition predict_constant_velocity(NavigationState& state, double dt, const ConstantVelocityNoise& noise) {
  const Vector3d turn = state.omega_body * dt;
  Transition step{MatrixXd::Identity(12, 12), MatrixXd::Zero(12, 12)};
  step.Phi.block<3, 3>(L::kPosition, L::kVelocity) = Matrix3d::Identity() * dt;
  step.Phi.block<3, 3>(L::kAttitude, L::kAttitude) = so3_exp(-turn);
  step.Phi.block<3, 3>(L::kAttitude, L::kRate) = so3_right_jacobian(turn) * dt;
  add_integrated_noise(step.Q, L::kPosition, L::kVelocity, noise.acceleration_density, dt);
  add_integrated_noise(step.Q, L::kAttitude, L::kRate, noise.angular_acceleration_density, dt);

  state.T_world_body.p += state.v_world_body * dt;
  state.T_world_body.R = so3_normalized(state.T_world_body.R * so3_exp(turn));
  return step;
}

Transition predict_odometry(NavigationState& state, const Vector3d& v_body, const Vector3d& omega_body,
                            double dt, const OdometryNoise& noise) {
  const Vector3d turn = omega_body * dt;
  const Matrix3d R = state.T_world_body.R;
  const Matrix3d half = so3_exp(0.5 * turn);
  const Matrix3d R_mid = R * half;
  Transition step{MatrixXd::Identity(6, 6), MatrixXd::Zero(6, 6)};
  step.Phi.block<3, 3>(L::kPosition, L::kAttitude) = -dt * R * skew(half * v_body);
  step.Phi.block<3, 3>(L::kAttitude, L::kAttitude) = so3_exp(-turn);

  // Inputs (v, omega) enter through G; their noise is one draw per step.
  Eigen::Matrix<double, 6, 6> G = Eigen::Matrix<double, 6, 6>::Zero();
  G.block<3, 3>(L::kPosition, 0) = dt * R_mid;
  G.block<3, 3>(L::kPosition, 3) = -dt * R_mid * skew(v_body) * so3_right_jacobian(0.5 * turn) * (0.5 * dt);
  G.block<3, 3>(L::kAttitude, 3) = dt * so3_right_jacobian(turn);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << noise.sigma_v, noise.sigma_omega;
  step.Q = G * sigma.cwiseAbs2().asDiagonal() * G.transpose();

  state.T_world_body.p += dt * (R_mid * v_body);
  state.T_world_body.R = so3_normalized(R * so3_exp(turn));
  state.v_world_body = state.T_world_body.R * v_body;
  state.omega_body = omega_body;
  return step;
}

}  // namespace limber
