// SPDX-License-Identifier: MIT
#include "window_problem.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/so3.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/predict/input_noise.hpp"
#include "predict/transition_sum.hpp"
#include "window_pixels.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using L = StateLayout;

namespace {

constexpr double kFreeTheta = 1e3;      // plausible errors: as good as nothing is known
constexpr double kStraightDepth = 0.5;  // share of an inverse depth

double squared(double x) { return x * x; }

/// x ⊖ y in error-state coordinates.
VectorXd difference(const NavigationState& x, const NavigationState& y, MotionModel motion) {
  VectorXd e(StateLayout{motion}.body_size());
  e.segment<3>(L::kPosition) = x.T_world_body.p - y.T_world_body.p;
  e.segment<3>(L::kAttitude) = so3_log(y.T_world_body.R.transpose() * x.T_world_body.R);
  e.segment<3>(L::kVelocity) = x.v_world_body - y.v_world_body;
  if (motion == MotionModel::kImu) {
    e.segment<3>(L::kBiasGyro) = x.bias_gyro - y.bias_gyro;
    e.segment<3>(L::kBiasAccel) = x.bias_accel - y.bias_accel;
  } else {
    e.segment<3>(L::kRate) = x.omega_body - y.omega_body;
  }
  return e;
}

/// Derivative of difference(x, y) with respect to x; with respect to y it is minus difference_jacobian(−e).
MatrixXd difference_jacobian(const VectorXd& e) {
  MatrixXd J = MatrixXd::Identity(e.size(), e.size());
  J.block<3, 3>(L::kAttitude, L::kAttitude) = so3_right_jacobian_inverse(e.segment<3>(L::kAttitude));
  return J;
}

void add_prior(const WindowModel& model, const WindowFrame& first, WindowNormal& out) {
  const auto [e, J, information] = prior_residual(model, first);
  const Index n = model.body_size();
  out.A.topLeftCorner(n, n) += congruence(transposed(J), information);
  out.g.head(n) -= J.transpose() * information * e;
  out.cost += 0.5 * e.dot(information * e);
}

void add_motion(const WindowModel& model, const WindowState& state, WindowNormal& out) {
  const Index n = model.body_size();
  const Index size = model.frame_size();
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    const auto [e, J, F, Q] = motion_residual(model, state, k);
    const MatrixXd information = Cholesky(Q).inverse();
    const Index a = static_cast<Index>(k - 1) * size;
    const Index b = a + size;
    const VectorXd Ie = information * e;
    out.A.block(a, a, n, n) += congruence(transposed(F), information);
    add_product(out.A.block(b, a, n, n), -1.0, multiply(transposed(J), information), F);
    out.A.block(b, b, n, n) += congruence(transposed(J), information);
    out.g.segment(a, n) += F.transpose() * Ie;
    out.g.segment(b, n) -= J.transpose() * Ie;
    out.cost += 0.5 * e.dot(Ie);
  }
}

void add_free_theta(const WindowModel& model, const WindowState& state, WindowNormal& out) {
  const double weight = 1.0 / squared(kFreeTheta);
  for (std::size_t k = 0; k < state.frames.size(); ++k) {
    const Index at = static_cast<Index>(k) * model.frame_size() + model.body_size();
    const VectorXd& theta = state.frames[k].theta;
    out.A.diagonal().segment(at, theta.size()).array() += weight;
    out.g.segment(at, theta.size()) -= weight * theta;
    out.cost += 0.5 * weight * theta.squaredNorm();
  }
}

/// A := 0. Other frames than the neighbours are known to poses alone, and nothing ever writes above the
/// blocks of the diagonal: what is zero there stays so.
void clear(const FrameLayout& layout, MatrixXd& A) {
  const Index size = layout.size(), n = layout.frames * size;
  if (A.rows() != n) {
    A.setZero(n, n);
    return;
  }
  for (Index at = 0; at < n; at += size) {
    A.block(at, at, n - at, layout.pose).setZero();
    A.block(at, at + layout.pose, std::min(2 * size, n - at), size - layout.pose).setZero();
  }
}

/// Moves the depth in a straight line, where the step is no longer than half of it: then what scales a map
/// moves frames and points alike straight on, however far. By inverse depths it would be a bent valley.
double moved_inverse_depth(double rho, double step) {
  const double share = step / rho;
  return std::abs(share) < kStraightDepth ? rho / (1.0 - share) : rho + step;
}

/// Of the inputs to a frame: what was stated, and a step of the biases.
ImuNoise imu_noise_to(const NavigatorOptions& options, const WindowFrame& frame) {
  ImuNoise out = options.imu_noise;
  const double root = std::sqrt(frame.duration());
  if (root > 0.0) {
    out.gyro_walk = std::hypot(out.gyro_walk, frame.gyro_step / root);
    out.accel_walk = std::hypot(out.accel_walk, frame.accel_step / root);
  }
  return out;
}

/// Time of a frame's steps for which samples say nothing any more: there they are of a body without force and
/// turn, as attitude and biases have it.
double forgotten_s(const WindowFrame& frame) {
  double out = 0.0;
  for (const InputStep& step : frame.steps) {
    out += step.dt * (1.0 - std::min(step.angular_unknown.memory, step.linear_unknown.memory));
  }
  return out;
}

SummedInputs summed(const WindowModel& model, const WindowState& state, std::size_t frame) {
  const NavigatorOptions& options = model.options;
  const NavigationState& from = state.frames[frame - 1].nav;
  const WindowFrame& to = state.frames[frame];
  const MotionNoise noise{imu_noise_to(options, to), {}, options.constant_velocity_noise};
  SummedInputs out{motion_between(options.motion, to.duration(), to.steps, from, noise, 0.0, options.gravity),
                   from.T_world_body.R, forgotten_s(to)};
  out.between.Q.diagonal().array() += squared(kJitter);
  return out;
}

/// Sums are good to first order about the gyroscope's bias that they were made with, and where samples are
/// forgotten for that attitude and those biases alone.
bool holds(const SummedInputs& inputs, const NavigationState& from, double gravity) {
  constexpr double kSquare = 1e-6;                    // [rad], first order left out
  constexpr double kTurnOff = 1e-6, kPushOff = 1e-5;  // [rad], [m/s]
  const MotionBetween& between = inputs.between;
  if (between.motion != MotionModel::kImu) {
    return true;
  }
  const double gyro = (from.bias_gyro - between.delta.bias_gyro).norm();
  const double accel = (from.bias_accel - between.delta.bias_accel).norm() +
                       gravity * (from.T_world_body.R - inputs.R_from).norm();
  return squared(gyro * between.dt) <= kSquare && gyro * inputs.forgotten_s <= kTurnOff &&
         accel * inputs.forgotten_s <= kPushOff;
}

Transition predict_step(const NavigatorOptions& options, const ImuNoise& noise, const InputStep& step,
                        NavigationState& nav) {
  if (options.motion != MotionModel::kImu) {
    return predict_constant_velocity(nav, step.dt, options.constant_velocity_noise);
  }
  const ImuStep imu = imu_step(step, nav, noise, options.gravity);
  return predict_imu(nav, imu.omega, imu.accel, step.dt, imu.noise, options.gravity);
}

}  // namespace

double WindowFrame::duration() const {
  double dt = 0.0;
  for (const InputStep& step : steps) {
    dt += step.dt;
  }
  return dt;
}

Transition predict_over(const NavigatorOptions& options, const WindowFrame& frame, NavigationState& nav) {
  TransitionSum sum(StateLayout{options.motion}.body_size());
  const ImuNoise noise = imu_noise_to(options, frame);
  for (const InputStep& step : frame.steps) {
    sum.add(predict_step(options, noise, step, nav));
    nav.t_ns = step.t_end_ns;
  }
  return sum.sum();
}

void sum_up_inputs(const WindowModel& model, WindowState& state) {
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    std::shared_ptr<const SummedInputs>& inputs = state.frames[k].inputs;
    if (!inputs || !holds(*inputs, state.frames[k - 1].nav, model.options.gravity)) {
      inputs = std::make_shared<const SummedInputs>(summed(model, state, k));
    }
  }
}

void forget_sums(WindowState& state) {
  for (WindowFrame& frame : state.frames) {
    frame.inputs.reset();
  }
}

PriorResidual prior_residual(const WindowModel& model, const WindowFrame& first) {
  const WindowPrior& prior = model.prior;
  const bool imu = model.options.motion == MotionModel::kImu;
  NavigationState mean;
  mean.T_world_body.R = model.R_first;
  VectorXd e = difference(first.nav, mean, model.options.motion);
  VectorXd weight(model.body_size());
  weight.segment<3>(L::kPosition).setConstant(1.0 / squared(prior.position));
  weight.segment<3>(L::kAttitude).setConstant(0.0);
  weight.segment<3>(L::kVelocity).setConstant(1.0 / squared(prior.velocity));
  weight.segment<3>(L::kBiasGyro).setConstant(1.0 / squared(imu ? prior.bias_gyro : prior.rate));
  if (imu) {
    weight.segment<3>(L::kBiasAccel).setConstant(1.0 / squared(prior.bias_accel));
  }
  MatrixXd information = weight.asDiagonal();
  const double tilt = imu ? prior.tilt : prior.yaw;
  const Vector3d attitude(1.0 / squared(tilt), 1.0 / squared(tilt), 1.0 / squared(prior.yaw));
  const Matrix3d& R = model.R_first;
  information.block<3, 3>(L::kAttitude, L::kAttitude) = R.transpose() * attitude.asDiagonal() * R;
  MatrixXd J = difference_jacobian(e);
  return {std::move(e), std::move(J), std::move(information)};
}

MotionResidual motion_residual(const WindowModel& model, const WindowState& state, std::size_t frame) {
  std::shared_ptr<const SummedInputs> inputs = state.frames[frame].inputs;
  if (!inputs) {
    inputs = std::make_shared<const SummedInputs>(summed(model, state, frame));
  }
  MotionError error = motion_error(inputs->between, state.frames[frame - 1].nav, state.frames[frame].nav,
                                   model.options.gravity);
  return {std::move(error.error), std::move(error.J_to), -error.J_from, inputs->between.Q};
}

MatrixXd covariance_of(const MotionResidual& motion, const MatrixXd& covariance, Index from, Index to) {
  const Index n = motion.e.size();
  const MatrixXd FP = multiply(motion.F, covariance.block(from, to, n, n).eval());
  return congruence(motion.F, covariance.block(from, from, n, n).eval()) +
         congruence(motion.J, covariance.block(to, to, n, n).eval()) - multiply(FP, transposed(motion.J)) -
         multiply(motion.J, transposed(FP));
}

BodyPoint point_in_body(const WindowState& state, const MountedRig& rig, std::size_t cam,
                        const WindowPoint& point, std::size_t frame) {
  const Anchor anchor{state.frames[point.anchor()].nav.T_world_body, rig[0].T_cam_body.inverse()};
  return body_point_at_exposure(rig[cam], state.frames[frame].nav.T_world_body, point.landmark, &anchor);
}

std::vector<MountedRig> rigs_of(const WindowModel& model, const WindowState& state) {
  std::vector<MountedRig> out;
  for (const WindowFrame& frame : state.frames) {
    StereoCalibration calibration = model.calibration;
    calibration.theta += model.directions * frame.theta;
    out.push_back(mount(calibration));
    for (MountedCamera& camera : out.back()) {
      camera.motion = {frame.nav.v_world_body, frame.omega - frame.nav.bias_gyro};
    }
  }
  return out;
}

WindowNormal linearise(const WindowModel& model, const WindowState& state, WindowNormal memory) {
  const Index n = static_cast<Index>(state.frames.size()) * model.frame_size();
  const auto points = static_cast<Index>(3 * state.points.size());
  WindowNormal out = std::move(memory);
  out.cost = out.left = 0.0;
  out.layout = model.layout(state.frames.size());
  clear(out.layout, out.A);
  out.W.setZero(out.layout.rest_size(), points);
  out.V.assign(state.points.size(), Matrix3d::Zero());
  out.g = VectorXd::Zero(n);
  out.g_points = VectorXd::Zero(points);
  out.seen.clear();
  for (const WindowPoint& point : state.points) {
    out.seen.push_back({static_cast<Index>(point.anchor()), static_cast<Index>(point.seen.back().frame)});
  }
  add_prior(model, state.frames.front(), out);
  add_motion(model, state, out);
  add_free_theta(model, state, out);
  add_points(model, state, out);
  return out;
}

WindowState moved(const WindowModel& model, WindowState state, const VectorXd& dx,
                  const VectorXd& dx_points) {
  Index at = 0;
  for (WindowFrame& frame : state.frames) {
    NavigationState& nav = frame.nav;
    nav.T_world_body.p += dx.segment<3>(at + L::kPosition);
    nav.T_world_body.R = so3_normalized(nav.T_world_body.R * so3_exp(dx.segment<3>(at + L::kAttitude)));
    nav.v_world_body += dx.segment<3>(at + L::kVelocity);
    if (model.options.motion == MotionModel::kImu) {
      nav.bias_gyro += dx.segment<3>(at + L::kBiasGyro);
      nav.bias_accel += dx.segment<3>(at + L::kBiasAccel);
    } else {
      nav.omega_body += dx.segment<3>(at + L::kRate);
    }
    frame.theta += dx.segment(at + model.body_size(), frame.theta.size());
    at += model.frame_size();
  }
  for (std::size_t j = 0; j < state.points.size(); ++j) {
    const Vector3d step = dx_points.segment<3>(static_cast<Index>(3 * j));
    Vector3d& value = state.points[j].landmark.value;
    value.head<2>() += step.head<2>();
    value.z() = moved_inverse_depth(value.z(), step.z());
  }
  return state;
}

}  // namespace limber::detail
