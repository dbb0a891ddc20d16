// SPDX-License-Identifier: MIT
#include "limber/initialize/initialize.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "limber/core/so3.hpp"
#include "limber/initialize/stereo_motion.hpp"
#include "limber/measure/rig.hpp"
#include "limber/predict/input_buffer.hpp"
#include "limber/predict/motion.hpp"

namespace limber {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using L = StateLayout;

namespace {

// Standing still: the spread of rate and specific force over the window is no more than noise.
constexpr double kStillRate = 0.02;   // [rad/s]
constexpr double kStillAccel = 0.15;  // [m/s^2]

// Uncertainty of what the window gives.
constexpr double kVelocityShare = 0.1;    // of the speed: two plausible errors of the baseline's length
constexpr double kVelocityFloor = 0.05;   // [m/s]
constexpr double kVelocityUnknown = 2.0;  // [m/s], no stereo motion at all
constexpr double kStillVelocity = 0.02;   // [m/s]
constexpr double kStillTilt = 0.01;       // [rad], accelerometer bias over gravity
constexpr double kMovingTilt = 0.05;      // [rad]
constexpr double kYaw = 1e-4;             // [rad], by convention zero
constexpr double kBiasGyro = 0.02;        // [rad/s], after the still or first mean is taken out
constexpr double kBiasGyroUnknown = 0.1;  // [rad/s]
constexpr double kBiasAccel = 0.1;        // [m/s^2]

/// World z up, camera z forward, x right, y down.
Matrix3d level_world_from_camera() {
  Matrix3d R;
  R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return R;
}

/// Rotation about the world's z-axis that makes the body's (or camera's) forward axis point along x.
Matrix3d without_yaw(const Matrix3d& R_world_body, const Vector3d& forward_body) {
  const Vector3d forward = R_world_body * forward_body;
  const double yaw = std::atan2(forward.y(), forward.x());
  return so3_exp(Vector3d(0.0, 0.0, -yaw)) * R_world_body;
}

struct Mean {
  Vector3d value = Vector3d::Zero();
  double spread = 0.0;
};

template <typename Field>
Mean mean_of(std::span<const ImuSample> imu, Field field) {
  Mean out;
  for (const ImuSample& sample : imu) {
    out.value += sample.*field;
  }
  out.value /= static_cast<double>(imu.size());
  for (const ImuSample& sample : imu) {
    out.spread += (sample.*field - out.value).squaredNorm();
  }
  out.spread = std::sqrt(out.spread / static_cast<double>(imu.size()));
  return out;
}

/// Positions and attitudes that the inertial samples alone give, starting from rest at the origin without
/// gravity.
std::vector<NavigationState> integrate(std::span<const ImuSample> imu, const std::vector<StampedPose>& motion,
                                       const Vector3d& bias_gyro) {
  InputBuffer buffer;
  for (const ImuSample& sample : imu) {
    buffer.add({sample.t_ns, sample.omega_imu, sample.accel_imu});
  }
  NavigationState state;
  state.t_ns = motion.front().t_ns;
  state.bias_gyro = bias_gyro;
  std::vector<NavigationState> out = {state};
  for (std::size_t k = 1; k < motion.size(); ++k) {
    for (const InputStep& step : buffer.steps(motion[k - 1].t_ns, motion[k].t_ns)) {
      (void)predict_imu(state, step.first, step.second, step.dt, ImuNoise{}, 0.0);
    }
    out.push_back(state);
  }
  return out;
}

/// Gyro bias that makes the integrated turn agree with the stereo motion's, first order.
Vector3d gyro_bias_from(std::span<const ImuSample> imu, const std::vector<StampedPose>& motion) {
  const NavigationState end = integrate(imu, motion, Vector3d::Zero()).back();
  const double T = 1e-9 * static_cast<double>(motion.back().t_ns - motion.front().t_ns);
  return so3_log(motion.back().T_world_body.R.transpose() * end.T_world_body.R) / T;
}

struct VelocityAndGravity {
  Vector3d v;        // of the body at the first frame, in its body frame [m/s]
  Vector3d gravity;  // in the first body frame [m/s^2]
};

/// p_k = v t + g t²/2 + (inertial part), least squares over the window; |g| is left free and checked.
std::optional<VelocityAndGravity> solve_velocity_gravity(std::span<const ImuSample> imu,
                                                         const std::vector<StampedPose>& motion,
                                                         double gravity) {
  if (motion.size() < 4) {
    return std::nullopt;
  }
  const std::vector<NavigationState> inertial = integrate(imu, motion, gyro_bias_from(imu, motion));
  const auto rows = static_cast<Eigen::Index>(3 * (motion.size() - 1));
  MatrixXd A(rows, 6);
  VectorXd b(rows);
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const double t = 1e-9 * static_cast<double>(motion[k].t_ns - motion[0].t_ns);
    const auto at = static_cast<Eigen::Index>(3 * (k - 1));
    A.block<3, 3>(at, 0) = Matrix3d::Identity() * t;
    A.block<3, 3>(at, 3) = Matrix3d::Identity() * (0.5 * t * t);
    b.segment<3>(at) = motion[k].T_world_body.p - inertial[k].T_world_body.p;
  }
  const VectorXd x = A.colPivHouseholderQr().solve(b);
  const VelocityAndGravity out{x.head<3>(), x.tail<3>()};
  const double ratio = out.gravity.norm() / gravity;
  if (!x.allFinite() || ratio < 0.7 || ratio > 1.3) {
    return std::nullopt;
  }
  return out;
}

/// p_k = v t + a t²/2.
std::optional<Vector3d> velocity_from(const std::vector<StampedPose>& motion) {
  if (motion.size() < 2) {
    return std::nullopt;
  }
  const Eigen::Index unknowns = motion.size() < 4 ? 1 : 2;
  MatrixXd A(static_cast<Eigen::Index>(motion.size()) - 1, unknowns);
  MatrixXd b(A.rows(), 3);
  for (std::size_t k = 1; k < motion.size(); ++k) {
    const double t = 1e-9 * static_cast<double>(motion[k].t_ns - motion[0].t_ns);
    const auto row = static_cast<Eigen::Index>(k) - 1;
    A(row, 0) = t;
    if (unknowns == 2) {
      A(row, 1) = 0.5 * t * t;
    }
    b.row(row) = motion[k].T_world_body.p.transpose();
  }
  return Vector3d(A.colPivHouseholderQr().solve(b).row(0).transpose());
}

double velocity_sigma(double speed) { return std::max(kVelocityFloor, kVelocityShare * speed); }

/// Attitude uncertainty: tilt about the world's horizontal axes, yaw fixed by convention; given in the body
/// frame.
Matrix3d attitude_covariance(const Matrix3d& R_world_body, double tilt) {
  const Vector3d world(tilt * tilt, tilt * tilt, kYaw * kYaw);
  return R_world_body.transpose() * world.asDiagonal() * R_world_body;
}

InitialState start_with_imu(const StartWindow& window, const std::vector<StampedPose>& motion, double gravity,
                            const Vector3d& forward_body) {
  const Mean rate = mean_of(window.imu, &ImuSample::omega_imu);
  const Mean accel = mean_of(window.imu, &ImuSample::accel_imu);
  const bool still = rate.spread < kStillRate && accel.spread < kStillAccel && rate.value.norm() < 0.1 &&
                     std::abs(accel.value.norm() - gravity) < 0.3;
  NavigationState nav;
  InitialSigma sigma;
  sigma.bias_accel = kBiasAccel;
  double tilt = kMovingTilt;
  Vector3d up_body = accel.value.normalized();
  Vector3d v_body = Vector3d::Zero();
  if (still) {
    tilt = kStillTilt;
    nav.bias_gyro = rate.value;
    sigma.bias_gyro = kBiasGyro;
    sigma.velocity = kStillVelocity;
  } else {
    const std::optional<VelocityAndGravity> solved = solve_velocity_gravity(window.imu, motion, gravity);
    if (solved) {
      up_body = -solved->gravity.normalized();
      v_body = solved->v;
      nav.bias_gyro = gyro_bias_from(window.imu, motion);
      sigma.bias_gyro = kBiasGyro;
      sigma.velocity = velocity_sigma(v_body.norm());
    } else {
      tilt = 3.0 * kMovingTilt;
      v_body = velocity_from(motion).value_or(Vector3d::Zero());
      sigma.bias_gyro = kBiasGyroUnknown;
      sigma.velocity = motion.size() < 2 ? kVelocityUnknown : velocity_sigma(v_body.norm());
    }
  }
  const Matrix3d R = without_yaw(rotation_between(up_body, Vector3d::UnitZ()), forward_body);
  nav.t_ns = window.frames.front().t_ns;
  nav.T_world_body.R = R;
  nav.v_world_body = R * v_body;
  InitialState out = make_initial_state(nav, MotionModel::kImu, sigma);
  out.body_covariance.block<3, 3>(L::kAttitude, L::kAttitude) = attitude_covariance(R, tilt);
  return out;
}

InitialState start_without_imu(const StartWindow& window, const std::vector<StampedPose>& motion,
                               const Matrix3d& R_world_body, MotionModel model) {
  NavigationState nav;
  nav.t_ns = window.frames.front().t_ns;
  nav.T_world_body.R = R_world_body;
  InitialSigma sigma;
  const std::optional<Vector3d> v_body = velocity_from(motion);
  sigma.velocity = v_body ? velocity_sigma(v_body->norm()) : kVelocityUnknown;
  nav.v_world_body = R_world_body * v_body.value_or(Vector3d::Zero());
  if (motion.size() >= 2) {
    const double dt = 1e-9 * static_cast<double>(motion[1].t_ns - motion[0].t_ns);
    nav.omega_body = so3_log(motion[1].T_world_body.R) / dt;
  } else {
    sigma.rate = 0.5;
  }
  return make_initial_state(nav, model, sigma);
}

}  // namespace

InitialState initialize(const StartWindow& window, const StereoCalibration& calibration, MotionModel motion,
                        double gravity) {
  if (window.frames.empty()) {
    throw std::invalid_argument("initialize: the window has no frame");
  }
  const Pose T_body_cam0 = body_from_cam0(calibration);
  const std::vector<StampedPose> moved = stereo_motion(window.frames, calibration);
  if (motion == MotionModel::kImu) {
    if (window.imu.empty()) {
      throw std::invalid_argument("initialize: the window has no IMU sample");
    }
    return start_with_imu(window, moved, gravity, T_body_cam0.R.col(2));
  }
  // No gravity: the camera is taken to look horizontally along x; a vehicle with odometry to stand level.
  const Matrix3d R_world_body = motion == MotionModel::kOdometry && calibration.body == BodyFrame::kImu
                                    ? Matrix3d::Identity()
                                    : Matrix3d(level_world_from_camera() * T_body_cam0.R.transpose());
  return start_without_imu(window, moved, R_world_body, motion);
}

}  // namespace limber
