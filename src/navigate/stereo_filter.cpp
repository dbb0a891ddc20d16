// SPDX-License-Identifier: MIT
#include "limber/navigate/stereo_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_set>
#include <utility>

#include "limber/core/time.hpp"
#include "limber/landmarks/landmark_initialization.hpp"
#include "limber/landmarks/map_management.hpp"
#include "limber/predict/input_noise.hpp"
#include "limber/stack/linearization_point.hpp"
#include "limber/update/gate.hpp"
#include "parameter_roles.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using namespace detail;

namespace {

NavigatorOptions completed(NavigatorOptions options) {
  options.landmark_init.kind = options.landmarks;
  if (options.method == Method::kAdaptive && !options.health) {
    options.health.emplace();  // it lives on what the monitor sees
  }
  if (!(options.sigma_px.array() > 0.0).all()) {
    throw std::invalid_argument("navigator: sigma_px must be positive");
  }
  if (!(options.gate_probability > 0.0 && options.gate_probability < 1.0)) {
    throw std::invalid_argument("navigator: gate_probability must lie between 0 and 1");
  }
  return options;
}

Estimate make_estimate(const NavigatorOptions& options, const StereoCalibration& calibration,
                       const InitialState& initial) {
  if (!(calibration.baseline() > 0.0)) {
    throw std::invalid_argument("navigator: the baseline is " + std::to_string(calibration.baseline()) +
                                " m, expected a positive one");
  }
  StateLayout layout{options.motion, has_theta(options), has_witness(options)};
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    layout.has_more[k] = (estimated(options) & parameters_of(kMoreBlocks[k])).any();
  }
  Estimate out(layout, initial.nav, initial.body_covariance, calibration.theta,
               theta_prior(options, calibration).cwiseAbs2().asDiagonal());
  const ParameterVector prior =
      options.estimated.cwiseMax(kNotEstimated * plausible_errors(calibration)).cwiseAbs2();
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    if (layout.has_more[k]) {
      out.P.set_diagonal_block(layout.more(k),
                               MatrixXd(prior.segment<6>(first_of(kMoreBlocks[k])).asDiagonal()));
    }
  }
  if (has_witness(options)) {
    out.restart_witness(kWidestErrors);
  }
  return out;
}

/// The frame as a method sees it: mono-left does not look through the right camera.
StereoFrame visible(const StereoFrame& frame, Method method) {
  StereoFrame out = frame;
  if (method == Method::kMonoLeft) {
    for (StereoObservation& observation : out.observations) {
      observation.in_cam1 = false;
    }
  }
  std::erase_if(out.observations, [](const StereoObservation& o) { return !o.in_cam0 && !o.in_cam1; });
  return out;
}

void check(const StereoFrame& frame, std::int64_t state_t_ns) {
  const auto fail = [&](const std::string& what) {
    throw std::invalid_argument("frame at " + std::to_string(frame.t_ns) + " ns " + what);
  };
  if (frame.t_ns < state_t_ns) {
    fail("is older than the state, " + std::to_string(state_t_ns) + " ns");
  }
  std::unordered_set<std::int64_t> seen;
  for (const StereoObservation& o : frame.observations) {
    if ((o.in_cam0 && !o.uv_cam0.allFinite()) || (o.in_cam1 && !o.uv_cam1.allFinite())) {
      fail("has a pixel that is not finite, track " + std::to_string(o.track_id));
    }
    if (!seen.insert(o.track_id).second) {
      fail("holds track " + std::to_string(o.track_id) + " twice");
    }
  }
}

}  // namespace

StereoFilter::StereoFilter(const NavigatorOptions& options, const StereoCalibration& calibration,
                           const InitialState& initial)
    : options_(completed(options)),
      given_(calibration),
      calibration_(calibration),
      scale_(plausible_error(calibration.baseline())),
      estimate_(make_estimate(options_, calibration, initial)) {
  check_parameters(options_, calibration);
  if (watches(options_)) {
    monitor_.emplace(*options_.health, calibration.baseline());
  }
}

void StereoFilter::add_imu(const ImuSample& sample) {
  if (options_.motion != MotionModel::kImu) {
    throw std::invalid_argument("navigator: IMU sample given, but the motion model is not kImu");
  }
  inputs_.add({sample.t_ns, sample.omega_imu, sample.accel_imu});
}

void StereoFilter::add_odometry(const OdometrySample& sample) {
  if (options_.motion != MotionModel::kOdometry) {
    throw std::invalid_argument("navigator: odometry sample given, but the motion model is not kOdometry");
  }
  inputs_.add({sample.t_ns, sample.v_body, sample.omega_body});
}

void StereoFilter::assume_theta(const RigParameters& theta) {
  if (estimate_.layout().has_theta) {
    throw std::invalid_argument("navigator: theta is part of the state and cannot be assumed");
  }
  calibration_.theta = theta;
  estimate_.theta = theta;
}

std::vector<InputStep> StereoFilter::steps_to(std::int64_t t_ns) {
  const std::int64_t begin_ns = estimate_.nav.t_ns;
  if (options_.motion != MotionModel::kConstantVelocity) {
    return inputs_.steps(begin_ns, t_ns);
  }
  InputStep step;
  step.t_end_ns = t_ns;
  step.dt = seconds_between(begin_ns, t_ns);
  return {step};
}

Transition StereoFilter::predict_step(const InputStep& step) {
  switch (options_.motion) {
    case MotionModel::kImu:
      return predict_imu(estimate_.nav, step.first, step.second, step.dt,
                         inflated(options_.imu_noise, step.gap), options_.gravity);
    case MotionModel::kOdometry:
      return predict_odometry(
          estimate_.nav, step.first, step.second, step.dt,
          per_step(options_.odometry_noise, inputs_.usual_interval_s(), step.dt, step.gap));
    case MotionModel::kConstantVelocity:
      break;
  }
  return predict_constant_velocity(estimate_.nav, step.dt, options_.constant_velocity_noise);
}

void StereoFilter::predict_to(std::int64_t t_ns) {
  if (t_ns <= estimate_.nav.t_ns) {
    return;
  }
  const double dt = seconds_between(estimate_.nav.t_ns, t_ns);
  const Index k = estimate_.layout().body_size();
  Transition whole{MatrixXd::Identity(k, k), MatrixXd::Zero(k, k)};
  for (const InputStep& step : steps_to(t_ns)) {
    omega_input_ = options_.motion == MotionModel::kOdometry ? step.second : step.first;
    const Transition part = predict_step(step);
    whole.Phi = part.Phi * whole.Phi;
    whole.Q = part.Phi * whole.Q * part.Phi.transpose() + part.Q;
  }
  estimate_.nav.t_ns = t_ns;
  estimate_.P.propagate_leading(whole.Phi, whole.Q);
  walk_parameters(dt);
}

/// Where theta is trusted a new landmark may believe all its pixels at once: lcekf without constraints is the
/// ekf. Else what theta touches is left to the same frame's update.
bool StereoFilter::initializes_before_update() const {
  return constrains(options_) || softens(options_) || !fresh_.is_zero();
}

StereoFilter::LinearizationPoint StereoFilter::choose_linearization_point(const StereoFrame& frame) const {
  LinearizationPoint out{mounted(calibration_)};
  if (initializes_before_update()) {
    const Eigen::VectorXd off =
        linearization_point(estimate_, frame, out.rig[1], options_.sigma_px, linearization_prior());
    out.shift.head(off.size()) = off;
    out.rig = mounted(corrected(calibration_, out.shift));
  }
  return out;
}

StereoFilter::NewLandmarks StereoFilter::initialize_landmarks(const StereoFrame& frame,
                                                              const MountedRig& rig) {
  LandmarkInitOptions how = options_.landmark_init;
  how.mode = initializes_before_update() ? LandmarkInitMode::kDiffuse : LandmarkInitMode::kClassical;
  NewLandmarks fresh;
  int anchor = -1;
  for (const StereoObservation& observation : frame.observations) {
    if (!observation.in_cam0 || estimate_.find(observation.track_id) != nullptr) {
      continue;
    }
    if (anchor < 0 && options_.landmarks == LandmarkKind::kInverseDepth) {
      // Where the place of the camera on the body, or its time, is estimated, the camera itself is the
      // anchor.
      const std::array<bool, 3>& has_more = estimate_.layout().has_more;
      anchor =
          has_more.front() || has_more.back()
              ? estimate_.add_camera_anchor(cam0_pose(rig[0], estimate_.nav.T_world_body, estimate_.layout()))
              : estimate_.add_anchor(rig[0].T_cam_body.inverse());
    }
    const std::optional<RemainingRows> remaining =
        initialize_landmark(estimate_, observation, rig, options_.sigma_px, frame.t_ns, anchor, how);
    if (remaining) {
      fresh[observation.track_id] = *remaining;
    }
  }
  estimate_.drop_unused_anchor(anchor);
  return fresh;
}

StackedFrame StereoFilter::stack(const StereoFrame& frame, const LinearizationPoint& at,
                                 const NewLandmarks& fresh, FrameReport& report) const {
  StackedFrame stacked = stack_frame(estimate_, frame, at.rig, options_.sigma_px, fresh, report.refused);
  if (!at.shift.isZero(0.0)) {
    // r = H dx + D (theta - assumed) + noise, wherever it is linearised. What is constrained does not notice;
    // what is trusted, or expected to be small (soft), is the assumed rig and not the linearisation point.
    stacked.measurement.residual += stacked.measurement.D * at.shift.head(stacked.measurement.D.cols());
  }
  return stacked;
}

std::vector<bool> StereoFilter::gate_points(const StackedFrame& stacked, const ParameterErrorModel& model,
                                            FrameReport& report) const {
  std::vector<bool> accepted(stacked.track_ids.size(), true);
  if (!options_.gate || stacked.measurement.rows() == 0) {
    return accepted;
  }
  const Innovation innovation = form_innovation(estimate_.P, stacked.measurement);
  const GateReport gated = gate(innovation, stacked.measurement.groups, model, options_.gate_probability);
  report.gate_overruled = gated.overruled;
  for (std::size_t g = 0; g < accepted.size(); ++g) {
    accepted[g] = gated.accepted[g];
    if (!accepted[g]) {
      report.refused.push_back(
          {stacked.track_ids[g], RefusalReason::kGate, gated.distance[g], gated.threshold[g]});
    }
  }
  return accepted;
}

void StereoFilter::constrained_update(const StackedFrame& stacked, const std::vector<bool>& accepted,
                                      const ParameterErrorModel& model, double dt, FrameReport& report) {
  if (stacked.measurement.rows() > 0) {
    const bool all = std::find(accepted.begin(), accepted.end(), false) == accepted.end();
    const Eigen::Matrix<double, 6, 6> P_theta =
        has_theta(options_) ? estimate_.P.diagonal_block<6>(estimate_.layout().theta())
                            : Eigen::Matrix<double, 6, 6>::Zero().eval();
    UpdateReport updated =
        update(estimate_.P, all ? stacked.measurement : stacked.measurement.subset(accepted), model);
    if (options_.method == Method::kConsider && updated.status == UpdateStatus::kUpdated) {
      // Schmidt: the gain's theta rows are zero, so its block stays; the cross-covariances are those of the
      // EKF.
      const Index at = estimate_.layout().theta();
      estimate_.P.set_diagonal_block(at, P_theta);
      updated.dx.segment<6>(at).setZero();
    }
    estimate_.retract(updated.dx);
    report.status = updated.status;
    report.nis = updated.nis;
    report.dof = updated.dof;
    report.rank = updated.rank;
    if (monitor_) {
      learn_from(model, updated, dt, report);
    }
  }
  if (estimates_theta(options_) || estimated(options_).any()) {
    use_estimated_calibration();
  }
}

void StereoFilter::record(const StackedFrame& stacked, const std::vector<bool>& accepted,
                          const NewLandmarks& fresh, FrameReport& report) {
  for (std::size_t g = 0; g < stacked.track_ids.size(); ++g) {
    Landmark* landmark = estimate_.find(stacked.track_ids[g]);
    landmark->refusals = accepted[g] ? 0 : landmark->refusals + 1;
    landmark->last_seen_ns = report.t_ns;
    report.used += accepted[g] ? 1 : 0;
  }
  for (const Refusal& refusal : report.refused) {
    Landmark* landmark = estimate_.find(refusal.track_id);
    if (refusal.reason == RefusalReason::kNotProjectable) {
      ++landmark->refusals;
    }
    // A new landmark that contradicts its own frame is none.
    if (fresh.contains(refusal.track_id)) {
      estimate_.remove_landmark(refusal.track_id);
    }
  }
}

FrameReport StereoFilter::process(const StereoFrame& raw) {
  check(raw, estimate_.nav.t_ns);
  const StereoFrame frame = visible(raw, options_.method);
  const double dt = seconds_between(estimate_.nav.t_ns, frame.t_ns);
  FrameReport report;
  report.t_ns = frame.t_ns;
  report.observed = frame.observations.size();

  predict_to(frame.t_ns);                                             // Eqs. (4), (7)
  update_active_set(estimate_, frame, last_frame_ns_, options_.map);  // compressed filter
  const LinearizationPoint at = choose_linearization_point(frame);    // for Eq. (16)
  report.removed = forget_misplaced(estimate_, frame, last_frame_ns_, at.rig[0], options_.map);
  NewLandmarks fresh;
  if (initializes_before_update()) {
    fresh = initialize_landmarks(frame, at.rig);  // Eqs. (29)-(32)
  }
  const StackedFrame stacked = stack(frame, at, fresh, report);  // Eqs. (23)-(28)
  const ParameterErrorModel model = error_model();
  const std::vector<bool> accepted = gate_points(stacked, model, report);
  constrained_update(stacked, accepted, model, dt, report);  // Eqs. (16)-(19)
  record(stacked, accepted, fresh, report);
  if (!initializes_before_update()) {
    fresh = initialize_landmarks(frame, mounted(calibration_));
  }
  report.initialized = fresh.size();
  report.removed += manage_map(estimate_, frame.t_ns, options_.map);
  last_frame_ns_ = frame.t_ns;
  return report;
}

}  // namespace limber
