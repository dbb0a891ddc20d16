// SPDX-License-Identifier: MIT
// What a window says of what it takes for exact of IMU and mount: docs/derivations/start.md.
#include "inertial_offsets.hpp"

#include <cstddef>
#include <vector>

#include "limber/core/dense.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/so3.hpp"
#include "limber/sensors/parameters.hpp"
#include "points_elimination.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr Index kOffsets = InertialEvidence::kOffsets;
constexpr double kSmall = 1e-3;  // an offset, in its unit
constexpr double kAbout = 0.04;  // [s], on either side of a frame

/// What each offset may be, roughly: keeps those that the motion does not tell from being anything.
/// A mount 0.1 rad, a lever arm 0.5 m, scales 0.1, axes 0.1 rad, a clock 0.1 s.
VectorXd plausible_offsets() {
  VectorXd out = VectorXd::Constant(kOffsets, 0.1);
  const OffsetPlace lever = place_of(InertialFactor::kLeverArm);
  out.segment(lever.first, lever.size).setConstant(0.5);
  return out;
}

/// What a sensor showed about a frame: a mean, since the noise of one sample would be taken for a motion.
Vector3d shown_about(const WindowState& state, std::size_t k, Vector3d InputStep::*sample) {
  Vector3d sum = Vector3d::Zero();
  double seconds = 0.0;
  const auto add = [&](const InputStep& step) {
    sum += step.dt * (step.*sample);
    seconds += step.dt;
  };
  const std::vector<InputStep>& before = state.frames[k].steps;
  for (auto step = before.rbegin(); step != before.rend() && seconds < kAbout; ++step) {
    add(*step);
  }
  if (k + 1 < state.frames.size()) {
    const double until = seconds + kAbout;
    for (const InputStep& step : state.frames[k + 1].steps) {
      if (seconds < until) {
        add(step);
      }
    }
  }
  return seconds > 0.0 ? Vector3d(sum / seconds) : sum;
}

Vector3d rate_at(const WindowState& state, std::size_t k) {
  return shown_about(state, k, &InputStep::angular) - state.frames[k].nav.bias_gyro;
}

/// The body where a mount of the cameras, which stay, has it.
NavigationState seen_by(const Pose& T_body_cam0, const Pose& assumed, const Vector3d& omega,
                        NavigationState nav) {
  const Pose body = nav.T_world_body * assumed * T_body_cam0.inverse();
  const Vector3d arm = nav.T_world_body.R.transpose() * (body.p - nav.T_world_body.p);
  nav.v_world_body += nav.T_world_body.R * omega.cross(arm);
  nav.T_world_body = body;
  return nav;
}

WindowState with_mount(const WindowModel& model, WindowState state, Index parameter, double offset) {
  const Pose& assumed = model.calibration.T_body_cam0;
  const Pose T = corrected(model.calibration, offset * ParameterVector::Unit(parameter)).T_body_cam0;
  for (std::size_t k = 0; k < state.frames.size(); ++k) {
    NavigationState& nav = state.frames[k].nav;
    nav = seen_by(T, assumed, rate_at(state, k), nav);
  }
  return state;
}

/// @param M  of what the samples say, added to it
WindowState with_samples(WindowState state, Vector3d InputStep::*sample, const Matrix3d& M) {
  for (WindowFrame& frame : state.frames) {
    frame.inputs.reset();
    for (InputStep& step : frame.steps) {
      step.*sample += M * (step.*sample);
    }
  }
  return state;
}

/// The body when the samples of a frame's stamp were taken, where cameras saw that much later.
WindowState with_clock(const WindowModel& model, WindowState state, double offset) {
  const Vector3d gravity(0.0, 0.0, -model.options.gravity);
  for (std::size_t k = 0; k < state.frames.size(); ++k) {
    NavigationState& nav = state.frames[k].nav;
    const Vector3d force = shown_about(state, k, &InputStep::linear) - nav.bias_accel;
    const Vector3d acceleration = nav.T_world_body.R * force + gravity, turn = offset * rate_at(state, k);
    nav.T_world_body.p -= offset * nav.v_world_body;
    nav.T_world_body.R = nav.T_world_body.R * so3_exp(Vector3d(-turn));
    nav.v_world_body -= offset * acceleration;
  }
  return state;
}

/// What all inputs, and what was known before them, are off by.
std::vector<VectorXd> residuals_of(const WindowModel& model, WindowState state) {
  sum_up_inputs(model, state);
  std::vector<VectorXd> out = {prior_residual(model, state.frames.front()).e};
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    out.push_back(motion_residual(model, state, k).e);
  }
  return out;
}

/// The residuals' derivatives, one matrix each, by finite differences.
class Derivatives {
 public:
  Derivatives(const WindowModel& model, const WindowState& state) : model_(model), state_(state) {
    columns_.resize(state.frames.size(), MatrixXd::Zero(model.body_size(), kOffsets));
    fill();
  }
  [[nodiscard]] const MatrixXd& of(std::size_t residual) const { return columns_[residual]; }

 private:
  void take(Index column, const WindowState& more, const WindowState& less, double apart) {
    const std::vector<VectorXd> a = residuals_of(model_, more), b = residuals_of(model_, less);
    for (std::size_t k = 0; k < a.size(); ++k) {
      columns_[k].col(column) = (a[k] - b[k]) / apart;
    }
  }

  /// Samples enter in a straight line, the others hardly bend.
  void fill() {
    const Index mount = first_of(ParameterBlock::kMount);
    for (Index k = 0; k < kBlockSize; ++k) {
      take(k, with_mount(model_, state_, mount + k, kSmall), with_mount(model_, state_, mount + k, -kSmall),
           2.0 * kSmall);
    }
    const Index turn = place_of(InertialFactor::kAccelTurn).first;
    const Index scale = place_of(InertialFactor::kAccelScales).first;
    for (Index k = 0; k < 3; ++k) {
      const Vector3d axis = kSmall * Vector3d::Unit(k);
      take(turn + k, with_samples(state_, &InputStep::linear, skew(axis)), state_, kSmall);
      take(scale + k, with_samples(state_, &InputStep::linear, axis.asDiagonal()), state_, kSmall);
    }
    take(place_of(InertialFactor::kGyroScale).first,
         with_samples(state_, &InputStep::angular, kSmall * Matrix3d::Identity()), state_, kSmall);
    take(place_of(InertialFactor::kClock).first, with_clock(model_, state_, kSmall),
         with_clock(model_, state_, -kSmall), 2.0 * kSmall);
  }

  const WindowModel& model_;
  const WindowState& state_;
  std::vector<MatrixXd> columns_;
};

/// The inputs of a window: their residuals, and how these go with the frames' errors and the offsets.
struct InputRows {
  MotionResidual motion;  ///< to a frame
  MatrixXd by_offsets, information;
  Index from = 0, to = 0;  ///< where the errors of both frames stand
};

std::vector<InputRows> rows_of(const WindowModel& model, const WindowState& state,
                               const Derivatives& derivatives) {
  std::vector<InputRows> out;
  for (std::size_t k = 1; k < state.frames.size(); ++k) {
    InputRows rows;
    rows.motion = motion_residual(model, state, k);
    rows.by_offsets = derivatives.of(k);
    rows.information = Cholesky(rows.motion.Q).inverse();
    rows.from = static_cast<Index>(k - 1) * model.frame_size();
    rows.to = rows.from + model.frame_size();
    out.push_back(std::move(rows));
  }
  return out;
}

/// The equations of the offsets beside the frames' errors: gradient, second derivatives, mixed ones.
struct OffsetEquations {
  VectorXd g = VectorXd::Zero(kOffsets);
  MatrixXd H = MatrixXd::Zero(kOffsets, kOffsets), mixed;
};

OffsetEquations equations_of(const WindowModel& model, const WindowState& state,
                             const Derivatives& derivatives, const std::vector<InputRows>& inputs) {
  OffsetEquations out;
  const Index n = model.body_size();
  out.mixed = MatrixXd::Zero(static_cast<Index>(state.frames.size()) * model.frame_size(), kOffsets);
  const auto add = [&out](const MatrixXd& E, const MatrixXd& information, const VectorXd& e) {
    const MatrixXd IE = multiply(information, E);
    out.g -= IE.transpose() * e;
    out.H += multiply(transposed(E), IE);
    return IE;
  };
  const PriorResidual prior = prior_residual(model, state.frames.front());
  out.mixed.topRows(n) += multiply(transposed(prior.J), add(derivatives.of(0), prior.information, prior.e));
  for (const InputRows& rows : inputs) {
    const MatrixXd IE = add(rows.by_offsets, rows.information, rows.motion.e);
    out.mixed.middleRows(rows.from, n) -= multiply(transposed(rows.motion.F), IE);
    out.mixed.middleRows(rows.to, n) += multiply(transposed(rows.motion.J), IE);
  }
  return out;
}

/// The gradient of the frames' errors, points eliminated.
VectorXd gradient_of_frames(const WindowNormal& normal) {
  VectorXd out = normal.g;
  out(normal.layout.rest()) -= PointsElimination(normal, 0.0).from_gradient();
  return out;
}

/// The best of all offsets, and what the frames' errors are then.
struct Best {
  VectorXd offsets, frames;
  MatrixXd covariance;  ///< of the offsets
  MatrixXd taken_up;    ///< of an offset by the frames' errors: they are less by that times it
};

/// Squares and degrees of freedom that are left to the inputs beside that.
void add_misfit(const std::vector<InputRows>& inputs, Index n, const Best& best, const MatrixXd& covariance,
                InertialEvidence& out) {
  for (const InputRows& rows : inputs) {
    const MotionResidual& motion = rows.motion;
    const VectorXd e = motion.e + rows.by_offsets * best.offsets +
                       motion.J * best.frames.segment(rows.to, n) -
                       motion.F * best.frames.segment(rows.from, n);
    out.misfit += e.dot(rows.information * e);
    const MatrixXd by_offsets = rows.by_offsets -
                                multiply(motion.J, best.taken_up.middleRows(rows.to, n).eval()) +
                                multiply(motion.F, best.taken_up.middleRows(rows.from, n).eval());
    const MatrixXd C =
        covariance_of(motion, covariance, rows.from, rows.to) + congruence(by_offsets, best.covariance);
    out.dof += static_cast<double>(n) - rows.information.cwiseProduct(C).sum();
  }
}

}  // namespace

InertialEvidence evidence_of(const WindowModel& model, WindowState state, const WindowNormal& normal,
                             const MatrixXd& covariance) {
  state.points.clear();  // the inputs know of none, and the states are varied many times
  sum_up_inputs(model, state);
  const Derivatives derivatives(model, state);
  const std::vector<InputRows> inputs = rows_of(model, state, derivatives);
  const OffsetEquations equations = equations_of(model, state, derivatives, inputs);
  const MatrixXd taken_up = multiply(covariance, equations.mixed);
  const VectorXd gradient = gradient_of_frames(normal);
  InertialEvidence out;
  const MatrixXd information = equations.H - multiply(transposed(equations.mixed), taken_up);
  out.information = 0.5 * (information + information.transpose());
  out.score = equations.g - taken_up.transpose() * gradient;
  const MatrixXd plausible = MatrixXd(plausible_offsets().cwiseAbs2().cwiseInverse().asDiagonal());
  const Cholesky with_plausible(MatrixXd(out.information + plausible));
  Best best{with_plausible.solve(out.score), {}, with_plausible.inverse(), taken_up};
  best.frames = covariance * gradient - taken_up * best.offsets;
  add_misfit(inputs, model.body_size(), best, covariance, out);
  return out;
}

}  // namespace limber::detail
