// SPDX-License-Identifier: MIT
#include "limber/initialize/sensor_start.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "limber/core/time.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/state/initial_state.hpp"
#include "navigate/parameter_roles.hpp"
#include "start_window.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace detail;

namespace {

/// Of a start to which images and inputs say nothing that agrees.
constexpr InitialSigma kNothingKnown{
    .position = 1e-3, .attitude = 0.5, .velocity = 5.0, .bias_accel = 0.5, .bias_gyro = 0.1, .rate = 1.0};

}  // namespace

/// Frames that were left out are predicted from the one before.
std::vector<SmoothedState> StartWindow::trajectory() const {
  const RestSeenSince since = rest_seen_since();
  std::vector<SmoothedState> out = rested_by_scale(since);
  const Index n = model.body_size();
  NavigationState nav;
  MatrixXd P;
  std::size_t next = 0;
  for (const WindowFrame& frame : frames) {
    if (next < solution->frames.size() && solution->frames[next].nav.t_ns == frame.nav.t_ns) {
      const Index at = static_cast<Index>(next) * model.frame_size();
      nav = solution->frames[next++].nav;
      P = covariance.block(at, at, n, n);
      const auto add_error = [&](const ShiftedSolution& one) {
        const VectorXd error = body_error(model.options.motion, nav, one.state.frames[next - 1].nav);
        P += error * error.transpose();
      };
      std::ranges::for_each(shifted, add_error);
      if (shifted_by_clock) {
        add_error(*shifted_by_clock);
      }
    } else {
      const Transition step = predict_over(model.options, frame, nav);
      P = step.Phi * P * step.Phi.transpose() + step.Q;
    }
    const MatrixXd from_first = seen_from_first(since, nav, P);
    const Eigen::Matrix<double, 6, 6> pose = from_first.topLeftCorner<6, 6>();
    const Index rest = n - StateLayout::kPoseSize;
    out.push_back({nav, 0.5 * (pose + pose.transpose()), from_first.bottomRightCorner(rest, rest)});
  }
  return out;
}

/// Inputs and images that no motion explains say nothing: at rest at the origin, as far as anybody knows.
SensorStartResult StartWindow::unsolved() const {
  NavigationState nav;
  nav.T_world_body.R = assumed_attitude();
  SensorStartResult out;
  out.solved = false;
  out.trajectory = rested;
  for (const StereoFrame& frame : raw) {
    nav.t_ns = frame.t_ns;
    InitialSigma sigma = kNothingKnown;
    sigma.position += kNothingKnown.velocity * seconds_between(raw.front().t_ns, frame.t_ns);
    out.initial = make_initial_state(nav, model.options.motion, sigma);
    const MatrixXd& P = out.initial.body_covariance;
    const Index rest = P.rows() - StateLayout::kPoseSize;
    out.trajectory.push_back({nav, P.topLeftCorner<6, 6>(), P.bottomRightCorner(rest, rest)});
  }
  return out;
}

bool may_trust_rig(const NavigatorOptions& options) {
  return options.method == Method::kAdaptive || doubts_lenses(options);
}

bool same_start(const NavigatorOptions& a, const StereoCalibration& rig_of_a, const NavigatorOptions& b,
                const StereoCalibration& rig_of_b) {
  const WindowModel of_a = window_model(a, rig_of_a), of_b = window_model(b, rig_of_b);
  return rig_of_a == rig_of_b && of_a.right == of_b.right &&
         of_a.directions.cols() == of_b.directions.cols() && of_a.directions == of_b.directions &&
         a.estimated.tail<kMoreParameters>() == b.estimated.tail<kMoreParameters>() && a.motion == b.motion &&
         a.imu_noise == b.imu_noise && a.learn_imu_noise == b.learn_imu_noise &&
         a.learn_imu_clock == b.learn_imu_clock && a.constant_velocity_noise == b.constant_velocity_noise &&
         a.learn_motion_noise == b.learn_motion_noise && a.sigma_px == b.sigma_px && a.gravity == b.gravity;
}

SensorStart::SensorStart(const NavigatorOptions& options, const StereoCalibration& calibration,
                         const StartOptions& start)
    : window_(std::make_unique<StartWindow>(options, calibration, start)) {}

SensorStart::SensorStart(SensorStart&&) noexcept = default;
SensorStart& SensorStart::operator=(SensorStart&&) noexcept = default;
SensorStart::~SensorStart() = default;

void SensorStart::add_imu(const ImuSample& sample) {
  const InputSample input{sample.t_ns, sample.omega_imu, sample.accel_imu};
  window_->add_by_clock(input);
  window_->samples.push_back(input);
}

void SensorStart::add_odometry(const OdometrySample& sample) {
  window_->checks.add({sample.t_ns, sample.omega_body, sample.v_body}, window_->inputs);
}

StartReport SensorStart::add_frame(const StereoFrame& frame) {
  StartWindow& w = *window_;
  if (!w.unused.empty()) {
    withdraw_from(w.raw, frame);
    withdraw_from(w.unused, frame);
    w.unused.push_back(frame);
    return w.report;
  }
  const InputReport inputs = w.push(frame);
  if (w.model.options.motion == MotionModel::kOdometry) {
    StartReport ready;
    ready.status = StartStatus::kReady;
    ready.inputs = inputs;
    return ready;
  }
  if (w.report.status == StartStatus::kWaiting) {
    w.report.waited_s = w.waited_s();
    if (w.is_due()) {
      w.report = w.solve_and_judge();
      w.rests = w.report.status == StartStatus::kWaiting && w.awaits_motion();
      if (w.rests) {
        w.forget_rest();
      }
    }
  }
  StartReport out = w.report;
  out.inputs = inputs;
  return out;
}

std::int64_t SensorStart::clock_offset_ns() const {
  return window_->clock_step ? window_->clock_step->offset_ns : 0;
}

SensorStartResult SensorStart::result() { return result_for(window_->model.options.method); }

SensorStartResult SensorStart::result_for(Method method) {
  StartWindow& w = *window_;
  if (w.frames.empty()) {
    throw std::invalid_argument("start: no frame yet");
  }
  SensorStartResult out;
  if (w.model.options.motion == MotionModel::kOdometry) {
    NavigationState nav;
    nav.t_ns = w.raw.back().t_ns;
    nav.T_world_body.R = w.assumed_attitude();
    out.initial = make_initial_state(nav, MotionModel::kOdometry, {});
    out.report.status = StartStatus::kReady;
    return out;
  }
  NavigatorOptions asked = w.model.options;
  asked.method = method;
  out.report = !w.solution || w.solved_s < w.length() ? w.solve_and_judge()
               : w.unused.empty()                     ? w.judged()
                                                      : w.report;
  if (out.report.status == StartStatus::kTimedOut && w.knows_no_scale()) {
    w.scale_told = false;
    w.take_scale_of_rig();
  }
  if (std::optional<StartWindow> trusting =
          may_trust_rig(asked) ? w.trusting(out.report.status) : std::nullopt) {
    w.shift_parameters();
    trusting->shift_parameters();
    out.initial = trusting->handed_over();
    out.initial.distrusting = std::make_shared<const InitialState>(w.handed_over());
    out.trajectory = trusting->trajectory();
    out.distrusting = w.trajectory();
    const InputReport inputs = out.report.inputs;
    out.report = trusting->judged();
    out.report.inputs = inputs;
  } else if (w.solution) {
    w.shift_parameters();
    out.initial = w.handed_over();
    out.trajectory = w.trajectory();
  } else {
    const StartReport report = out.report;
    out = w.unsolved();
    out.report = report;
  }
  if (!w.unused.empty()) {
    w.report = out.report;  // the start is over
  }
  out.bias_step_ns = w.stepped_before_ns;
  if (w.clock_step && w.clock_step->jumps()) {
    out.clock_step = w.clock_step;
  }
  out.unused = w.unused;
  if (out.solved) {
    out.used = w.raw;
  }
  return out;
}

std::vector<std::shared_ptr<const CalibrationReport>> show_start(const SensorStartResult& start,
                                                                 Navigator& navigator) {
  const std::vector<SmoothedState>& states = start.distrusting.empty() ? start.trajectory : start.distrusting;
  auto state = states.end() - static_cast<std::ptrdiff_t>(start.used.size());
  std::vector<std::shared_ptr<const CalibrationReport>> out;
  for (const StereoFrame& frame : start.used) {
    const MatrixXd& of_motion = state->motion_covariance;
    Matrix3d velocity = Matrix3d::Zero();
    if (has_scale(navigator.options().motion)) {
      velocity = of_motion.topLeftCorner<3, 3>();
    }
    out.push_back(navigator.watch_earlier(frame, state->nav, velocity));
    ++state;
  }
  return out;
}

}  // namespace limber
