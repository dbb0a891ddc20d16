// SPDX-License-Identifier: MIT
#include "window_problem.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/so3.hpp"
#include "limber/measure/stereo_model.hpp"
#include "limber/predict/input_noise.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using L = StateLayout;

namespace {

constexpr double kHuberSigmas = 3.0;     // standard deviations of a pixel, both axes
constexpr double kFreeTheta = 1e3;       // plausible errors: as good as nothing is known
constexpr double kFreeBaselines = 10.0;  // sigma of an inverse depth, over the baseline: the same
constexpr double kStraightDepth = 0.5;   // share of an inverse depth
constexpr double kLost = 30.0;           // cost of a point that does not project

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
  const WindowPrior& prior = model.prior;
  const bool imu = model.options.motion == MotionModel::kImu;
  NavigationState mean;
  mean.T_world_body.R = model.R_first;
  const VectorXd e = difference(first.nav, mean, model.options.motion);
  const Index n = model.body_size();
  VectorXd weight(n);
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
  const MatrixXd J = difference_jacobian(e);
  out.A.topLeftCorner(n, n) += congruence(transposed(J), information);
  out.g.head(n) -= J.transpose() * information * e;
  out.cost += 0.5 * e.dot(information * e);
}

void add_motion(const WindowModel& model, const WindowState& state, WindowNormal& out) {
  const Index n = model.body_size();
  const Index size = model.frame_size();
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    NavigationState predicted = state.frames[k - 1].nav;
    Transition step = predict_over(model.options, state.frames[k], predicted);
    step.Q.diagonal().array() += kJitter * kJitter;
    const VectorXd e = difference(state.frames[k].nav, predicted, model.options.motion);
    const MatrixXd information = Cholesky(step.Q).inverse();
    const Index a = static_cast<Index>(k - 1) * size;
    const Index b = a + size;
    const VectorXd Ie = information * e;
    const MatrixXd J = difference_jacobian(e);
    const MatrixXd F = multiply(difference_jacobian(-e), step.Phi);
    out.A.block(a, a, n, n) += congruence(transposed(F), information);
    add_product(out.A.block(b, a, n, n), -1.0, multiply(transposed(J), information), F);
    out.A.block(b, b, n, n) += congruence(transposed(J), information);
    out.g.segment(a, n) += F.transpose() * Ie;
    out.g.segment(b, n) -= J.transpose() * Ie;
    out.cost += 0.5 * e.dot(Ie);
  }
}

/// Columns of one pixel's Jacobian that belong to frames.
struct FrameBlock {
  Index col = 0;   // among all unknowns of the frames
  Index rest = 0;  // in the layout's rest
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, 6> J;
};

struct PixelRows {
  Vector2d r;  // whitened and weighted, measured minus predicted
  Eigen::Matrix<double, 2, 3> J_point;
  std::array<FrameBlock, 3> blocks;
  std::size_t used = 0;
};

void add_rows(const PixelRows& rows, std::size_t point, WindowNormal& out) {
  const auto at = static_cast<Index>(3 * point);
  out.V[point] += rows.J_point.transpose() * rows.J_point;
  out.g_points.segment<3>(at) += rows.J_point.transpose() * rows.r;
  for (std::size_t i = 0; i < rows.used; ++i) {
    const FrameBlock& bi = rows.blocks[i];
    out.W.block(bi.rest, at, bi.J.cols(), 3) += bi.J.transpose() * rows.J_point;
    out.g.segment(bi.col, bi.J.cols()) += bi.J.transpose() * rows.r;
    for (std::size_t j = 0; j < rows.used; ++j) {
      const FrameBlock& bj = rows.blocks[j];
      if (bi.col >= bj.col) {
        out.A.block(bi.col, bj.col, bi.J.cols(), bj.J.cols()) += bi.J.transpose() * bj.J;
      }
    }
  }
}

/// One pixel of one sighting, as rows or as the cost of a point that is lost.
void add_pixel(const WindowModel& model, const WindowState& state, const MountedRig& rig, std::size_t cam,
               std::size_t point, const WindowSighting& sighting, WindowNormal& out) {
  const WindowPoint& p = state.points[point];
  const std::optional<PointProjection> projection = project_sighting(state, rig, cam, p, sighting.frame);
  const StereoObservation& o = sighting.observation;
  if (!projection) {
    out.cost += kLost;
    return;
  }
  const Vector2d whiten = model.options.sigma_px.segment<2>(2 * static_cast<Index>(cam)).cwiseInverse();
  const Vector2d r = whiten.cwiseProduct((cam == 0 ? o.uv_cam0 : o.uv_cam1) - projection->uv);
  const double norm = r.norm();
  const double weight = norm <= kHuberSigmas ? 1.0 : std::sqrt(kHuberSigmas / norm);
  out.cost += norm <= kHuberSigmas ? 0.5 * norm * norm : kHuberSigmas * (norm - 0.5 * kHuberSigmas);
  const Eigen::Matrix2d G = weight * whiten.asDiagonal().toDenseMatrix();
  PixelRows rows;
  rows.r = weight * r;
  rows.J_point = G * projection->J_landmark;
  Eigen::Matrix<double, 2, 6> J_pose, J_anchor;
  J_pose << projection->J_position, projection->J_attitude;
  J_anchor << projection->J_anchor_position, projection->J_anchor_attitude;
  const bool own = p.anchor() == sighting.frame;
  const auto frame = static_cast<Index>(sighting.frame);
  const Index at = frame * model.frame_size();
  rows.blocks[rows.used++] = {at, out.layout.pose_in_rest(frame),
                              G * (own ? (J_pose + J_anchor).eval() : J_pose)};
  if (!own) {
    const auto anchored = static_cast<Index>(p.anchor());
    rows.blocks[rows.used++] = {anchored * model.frame_size(), out.layout.pose_in_rest(anchored),
                                G * J_anchor};
  }
  if (rig[cam].depends_on_theta && model.directions.cols() > 0) {
    rows.blocks[rows.used++] = {at + model.body_size(), out.layout.theta_in_rest(frame),
                                G * projection->J_theta * model.directions};
  }
  add_rows(rows, point, out);
}

void add_points(const WindowModel& model, const WindowState& state, WindowNormal& out) {
  std::vector<MountedRig> rigs;
  for (const WindowFrame& frame : state.frames) {
    rigs.push_back(rig_at(model, frame));
  }
  const double free = squared(model.calibration.baseline() / kFreeBaselines);
  for (std::size_t j = 0; j < state.points.size(); ++j) {
    const WindowPoint& point = state.points[j];
    for (const WindowSighting& sighting : point.seen) {
      if (sighting.observation.in_cam0) {
        add_pixel(model, state, rigs[sighting.frame], 0, j, sighting, out);
      }
      if (sighting.observation.in_cam1 && model.right) {
        add_pixel(model, state, rigs[sighting.frame], 1, j, sighting, out);
      }
    }
    const double rho = point.landmark.value.z();
    out.V[j](2, 2) += free;
    out.g_points(static_cast<Index>(3 * j) + 2) -= free * rho;
    out.cost += 0.5 * free * rho * rho;
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

/// A := 0, n×n. Nothing ever writes above the blocks of the diagonal: what is zero there stays so.
void clear_lower(Index n, Index block, MatrixXd& A) {
  if (A.rows() != n) {
    A.setZero(n, n);
    return;
  }
  for (Index at = 0; at < n; at += block) {
    A.block(at, at, n - at, block).setZero();
  }
}

/// Moves the depth in a straight line, where the step is no longer than half of it: then what scales a map
/// moves frames and points alike straight on, however far. By inverse depths it would be a bent valley.
double moved_inverse_depth(double rho, double step) {
  const double share = step / rho;
  return std::abs(share) < kStraightDepth ? rho / (1.0 - share) : rho + step;
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
  const Index n = StateLayout{options.motion}.body_size();
  Transition whole{MatrixXd::Identity(n, n), MatrixXd::Zero(n, n)};
  ImuNoise noise = options.imu_noise;
  const double root = std::sqrt(frame.duration());
  if (root > 0.0) {
    noise.gyro_walk = std::hypot(noise.gyro_walk, frame.gyro_step / root);
    noise.accel_walk = std::hypot(noise.accel_walk, frame.accel_step / root);
  }
  for (const InputStep& step : frame.steps) {
    const Transition part = predict_step(options, noise, step, nav);
    whole.Phi = multiply(part.Phi, whole.Phi);
    whole.Q = congruence(part.Phi, whole.Q) + part.Q;
    nav.t_ns = step.t_end_ns;
  }
  return whole;
}

std::optional<PointProjection> project_sighting(const WindowState& state, const MountedRig& rig,
                                                std::size_t cam, const WindowPoint& point,
                                                std::size_t frame) {
  const Anchor anchor{state.frames[point.anchor()].nav.T_world_body, rig[0].T_cam_body.inverse()};
  return project_point(rig[cam], body_point_at_exposure(rig[cam], state.frames[frame].nav.T_world_body,
                                                        point.landmark, &anchor));
}

MountedRig rig_at(const WindowModel& model, const WindowFrame& frame) {
  StereoCalibration calibration = model.calibration;
  calibration.theta += model.directions * frame.theta;
  MountedRig rig = mount(calibration);
  for (MountedCamera& camera : rig) {
    camera.motion = {frame.nav.v_world_body, frame.omega - frame.nav.bias_gyro};
  }
  return rig;
}

WindowNormal linearise(const WindowModel& model, const WindowState& state, WindowNormal memory) {
  const Index n = static_cast<Index>(state.frames.size()) * model.frame_size();
  const auto points = static_cast<Index>(3 * state.points.size());
  WindowNormal out = std::move(memory);
  out.cost = out.left = 0.0;
  out.layout = model.layout(state.frames.size());
  clear_lower(n, model.frame_size(), out.A);
  out.W.setZero(out.layout.rest_size(), points);
  out.V.assign(state.points.size(), Matrix3d::Zero());
  out.g = VectorXd::Zero(n);
  out.g_points = VectorXd::Zero(points);
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
