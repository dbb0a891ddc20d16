// SPDX-License-Identifier: MIT
// StereoFilter's inputs: samples in, prediction, what the images say against them, and a new beginning.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "check_inputs.hpp"
#include "limber/core/time.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "parameter_roles.hpp"
#include "propagate.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using namespace detail;

namespace {

/// A state that was never given a time takes that of the first sample or frame if that is further ahead [s].
constexpr double kNeverGivenATime = 60.0;
/// Where theta is trusted or estimated a wrong rig moves the pose, too: only what no rig can do counts [-].
constexpr double kTrustingFactor = 30.0;
constexpr double kStepAge = 1.0;   // [s], after which steps are supposed to begin anew
constexpr double kQuiet = 6.0;     // of the alarm's statistic: what 6 degrees of freedom show of themselves
constexpr double kFastest = 1e3;   // [m/s]: faster is broken
constexpr double kFarthest = 1e8;  // [m]
constexpr double kTooBlind = 0.15, kAnywhere = 0.5;  // [rad], of turn between two updates that nobody saw
constexpr double kAnewAttitude = 0.1;                // [rad], least uncertainty after a new beginning
constexpr double kAnewVelocity = 1.0;                // [m/s]
constexpr double kAnewPosition = 1.0;                // [m]
constexpr double kAnewRate = 0.5;                    // [rad/s]
constexpr double kAnewBiasGyro = 0.02, kAnewBiasAccel = 0.2;

}  // namespace

std::int64_t StereoFilter::started_at(std::int64_t t_ns) const {
  const std::int64_t state_ns = estimate_.nav().t_ns;
  const bool is_untouched =
      state_ns == 0 && inputs_.empty() && last_frame_ns_ == std::numeric_limits<std::int64_t>::min();
  return is_untouched && seconds_between(0, t_ns) > kNeverGivenATime ? t_ns : state_ns;
}

void StereoFilter::add(InputSample sample) {
  const std::int64_t stamp_ns = std::exchange(sample.t_ns, sample.t_ns - clock_offset_ns_);
  const std::int64_t state_ns = started_at(sample.t_ns);
  if (seconds_between(state_ns, sample.t_ns) > kLongestJump) {
    throw std::invalid_argument("input sample at " + std::to_string(sample.t_ns) +
                                " ns is hours ahead of the state, " + std::to_string(state_ns) +
                                " ns: is that another clock?");
  }
  checks_.add(sample, inputs_);
  estimate_.set_time(state_ns);
  if (has_processed_) {
    late_ += std::max(sample.t_ns, stamp_ns) < state_ns ? 1 : 0;
  } else if (sample.t_ns <= state_ns) {
    (void)checks_.take_counts();  // what failed before the state was is the start's to say
  }
}

std::vector<InputStep> StereoFilter::steps_to(std::int64_t t_ns) const {
  const std::int64_t begin_ns = estimate_.nav().t_ns;
  if (options_.motion != MotionModel::kConstantVelocity) {
    return inputs_.steps(begin_ns, t_ns);
  }
  InputStep step;
  step.t_end_ns = t_ns;
  step.dt = seconds_between(begin_ns, t_ns);
  return {step};
}

/// The body carried to t_ns by the inputs so far; changes nothing.
Propagation StereoFilter::propagated(std::int64_t t_ns) const {
  const OdometryNoise odometry = odometry_noise_ ? odometry_noise_->assumed() : options_.odometry_noise;
  return propagate(estimate_.nav(), steps_to(t_ns), options_, odometry, motion_noise(),
                   inputs_.usual_interval_s(), more_noise());
}

/// Of accelerations that no input shows.
ConstantVelocityNoise StereoFilter::motion_noise() const {
  ConstantVelocityNoise out = options_.constant_velocity_noise;
  if (motion_noise_) {
    out.acceleration_density *= motion_noise_->factors().accel;
    out.angular_acceleration_density *= motion_noise_->factors().gyro;
  }
  return out;
}

/// What inputs are noisier by than their samples and what was stated say.
MoreNoise StereoFilter::more_noise() const {
  MoreNoise more = estimate_.nav().t_ns < trusted_again_ns_ ? distrust_ : MoreNoise{};
  if (imu_noise_) {
    const MoreNoise learned = beside_stated(options_.imu_noise, imu_noise_->factors());
    more.angular += learned.angular;
    more.linear += learned.linear;
  }
  return more;
}

void StereoFilter::predict_to(std::int64_t t_ns) {
  if (t_ns <= estimate_.nav().t_ns) {
    return;
  }
  const double dt = seconds_between(estimate_.nav().t_ns, t_ns);
  const Propagation to = propagated(t_ns);
  inputs_.forget_before(t_ns);
  const Eigen::Vector3d way = to.nav.T_world_body.p - estimate_.nav().T_world_body.p;
  estimate_.set_nav(to.nav);
  omega_input_ = to.omega_input;
  estimate_.mutable_P().propagate_leading(to.whole.Phi, to.whole.Q);
  if (estimate_.layout().has_odometry_scale) {
    estimate_.move_with_odometry_scale(way);
  }
  if (estimate_.layout().has_supposed_steps) {
    estimate_.move_with_clock_step(to.by_clock);
  }
  blind_turn_ += to.whole.Q.diagonal().segment<3>(StateLayout::kAttitude).maxCoeff();
  walk_parameters(dt);
}

/// What lenses do to lengths that nothing but the baseline tells: all grow by a share, which no update shows.
PredictedState StereoFilter::with_doubtful_lengths(PredictedState state) const {
  if (!pixel_noise_ || has_scale(options_.motion) || options_.method == Method::kMonoLeft) {
    return state;
  }
  VectorXd growth = VectorXd::Zero(state.body_covariance.rows());
  growth.segment<3>(StateLayout::kPosition) = state.nav.T_world_body.p - estimate_.centre_of_growth();
  growth.segment<3>(StateLayout::kVelocity) = state.nav.v_world_body;
  growth *= pixel_noise_->report().length_sigma;
  state.body_covariance += growth * growth.transpose();
  return state;
}

PredictedState StereoFilter::predict(std::int64_t t_ns) const {
  const StateLayout& layout = estimate_.layout();
  const Index k = layout.body_size();
  const MatrixXd P = estimate_.P().block(0, 0, k, k);
  if (t_ns <= estimate_.nav().t_ns) {
    return with_doubtful_lengths({estimate_.nav(), P});
  }
  const Propagation to = propagated(t_ns);
  PredictedState out{to.nav, to.whole.Phi * P * to.whole.Phi.transpose() + to.whole.Q};
  // What a state behind the body moves the position, or all of the body, by.
  const auto couple = [&](Index at, const VectorXd& by) {
    const Index n = by.size();
    const MatrixXd with_body = to.whole.Phi * estimate_.P().block(0, at, k, 1) * by.transpose();
    out.body_covariance.leftCols(n) += with_body;
    out.body_covariance.topRows(n) += with_body.transpose();
    out.body_covariance.topLeftCorner(n, n) += estimate_.P().block(at, at, 1, 1)(0) * by * by.transpose();
  };
  if (layout.has_odometry_scale) {
    couple(layout.odometry_scale(), to.nav.T_world_body.p - estimate_.nav().T_world_body.p);
  }
  if (layout.has_supposed_steps) {
    couple(layout.clock_step(), to.by_clock);
    out.nav = estimate_.moved_with_clock_step(to.nav, to.by_clock);
  }
  return with_doubtful_lengths(std::move(out));
}

/// What the prediction from the state to t_ns will rest on.
InputReport StereoFilter::report_inputs(std::int64_t t_ns) {
  if (options_.motion == MotionModel::kConstantVelocity) {
    return {};
  }
  InputFaultCounts faults = checks_.take_counts();
  faults[InputFault::kLate] = std::exchange(late_, 0);
  return report_on(inputs_, faults, estimate_.nav().t_ns, t_ns);
}

/// No calibration can lead it astray.
bool StereoFilter::is_blind_to_rig() const {
  return (constrains(options_) && options_.constraints.kind == ConstraintSet::Kind::kFull) ||
         options_.method == Method::kMonoLeft;
}

/// chi^2 of the inputs against the images: what the frame corrected, beside what it could have had to
/// correct.
void StereoFilter::judge_inputs(const PoseCorrection& correction, FrameReport& report) {
  if (options_.motion == MotionModel::kConstantVelocity || correction.dt <= 0.0) {
    return;
  }
  const bool blind_to_rig = is_blind_to_rig();
  PoseCorrection counted = correction;
  if (!blind_to_rig) {
    counted.covariance *= kTrustingFactor;
  }
  InputContradiction found;
  const bool contradicted = input_alarm_.judge(counted, fit_steps(), found);
  report.inputs.chi2 = input_alarm_.statistic() * (blind_to_rig ? 1.0 : kTrustingFactor);
  if (contradicted) {
    report.inputs.status = std::max(report.inputs.status, InputStatus::kContradicted);
    if (found.step && !blind_to_rig) {
      found.astray_since_ns = steps_ns_;
    }
    report.inputs.contradiction = found;
    distrust_inputs(found);
    if (!blind_to_rig) {  // what the monitor saw while the fault grew was not the rig's
      restart_monitor();
      last_health_.reset();
    }
  } else if (follow_clock(report)) {
    report.inputs.status = std::max(report.inputs.status, InputStatus::kContradicted);
    report.inputs.contradiction = InputContradiction{};
    report.inputs.contradiction->clock_offset_ns = clock_offset_ns_;
  } else if (estimate_.layout().has_supposed_steps && input_alarm_.statistic() < kQuiet &&
             seconds_between(steps_ns_, estimate_.nav().t_ns) >= kStepAge) {
    restart_steps();
  }
}

void StereoFilter::distrust_inputs(const InputContradiction& found) {
  if (excitation_) {
    excitation_->jump();
  }
  if (found.clock_offset_ns) {
    set_clock_offset(*found.clock_offset_ns);
    return;
  }
  if (found.step) {
    open_steps(*found.step);
    return;
  }
  const double turn = found.turn / found.dt, speed = found.shift / found.dt;
  const auto open = [&](Index at, double sigma) {
    estimate_.mutable_P().set_diagonal_block(
        at, estimate_.P().diagonal_block<3>(at) + sigma * sigma * Eigen::Matrix3d::Identity());
  };
  const bool imu = options_.motion == MotionModel::kImu;
  open(StateLayout::kAttitude, found.turn);
  if (imu) {
    open(StateLayout::kVelocity, speed);
    open_steps({std::min(turn, kLargestStep.gyro), std::min(speed / InputAlarm::kCalm, kLargestStep.accel)});
    doubts_clock_ = true;
  }
  const double of_turn = turn * turn * found.dt;
  const double of_speed = speed * speed * (imu ? 1.0 / InputAlarm::kCalm : found.dt);
  if (estimate_.nav().t_ns >= trusted_again_ns_) {
    distrust_ = {};  // an older quarrel is over
  }
  distrust_ = {std::max(distrust_.angular, of_turn), std::max(distrust_.linear, of_speed)};
  trusted_again_ns_ = estimate_.nav().t_ns + static_cast<std::int64_t>(1e9 * InputAlarm::kCalm);
}

/// The frame's landmarks are no more: its points will be taken for new ones.
std::size_t StereoFilter::forget(const StereoFrame& frame) {
  std::size_t removed = 0;
  for (const StereoObservation& o : frame.observations) {
    if (estimate_.find(o.track_id) != nullptr) {
      estimate_.remove_landmark(o.track_id);
      ++removed;
    }
  }
  return removed;
}

/// Where nobody knows how the body turned, no landmark of before can be found in the image by a linear
/// update; where it may be anywhere, none that will be seen again either.
std::size_t StereoFilter::forget_after_blindness(const StereoFrame& frame) {
  if (blind_turn_ <= kTooBlind * kTooBlind) {
    return 0;
  }
  const bool anywhere = blind_turn_ > kAnywhere * kAnywhere && !frame.observations.empty();
  blind_turn_ = frame.observations.empty() ? blind_turn_ : 0.0;
  return anywhere ? forget_all() : forget(frame);
}

std::size_t StereoFilter::forget_all() {
  std::vector<std::int64_t> known;
  for (const Landmark& landmark : estimate_.landmarks()) {
    known.push_back(landmark.track_id);
  }
  for (const std::int64_t id : known) {
    estimate_.remove_landmark(id);
  }
  return known.size();
}

bool StereoFilter::is_broken() const {
  const NavigationState& nav = estimate_.nav();
  const Index k = estimate_.layout().body_size();
  const Eigen::VectorXd variance = estimate_.P().block(0, 0, k, k).diagonal();
  return !nav.T_world_body.p.allFinite() || !nav.T_world_body.R.allFinite() ||
         !nav.v_world_body.allFinite() || !variance.allFinite() || variance.minCoeff() < 0.0 ||
         nav.T_world_body.p.norm() > kFarthest || nav.v_world_body.norm() > kFastest;
}

/// Time goes on; pose, velocity and biases of the last sound frame stay, with what that start cannot know.
void StereoFilter::begin_anew() {
  const std::int64_t t_ns = estimate_.nav().t_ns;
  const double silence = std::max(seconds_between(sound_.nav.t_ns, t_ns), 0.0);
  InitialState anew = sound_;
  anew.nav.t_ns = t_ns;
  anew.nav.T_world_body.p += silence * anew.nav.v_world_body;
  MatrixXd P = MatrixXd(anew.body_covariance.diagonal().asDiagonal());
  const auto widen = [&](Index at, double sigma) {
    P.diagonal().segment<3>(at) = P.diagonal().segment<3>(at).cwiseMax(sigma * sigma).eval();
  };
  widen(StateLayout::kPosition, kAnewPosition + kAnewVelocity * silence);
  widen(StateLayout::kAttitude, kAnewAttitude);
  if (options_.motion != MotionModel::kOdometry) {
    widen(StateLayout::kVelocity, kAnewVelocity);
    widen(StateLayout::kRate, options_.motion == MotionModel::kImu ? kAnewBiasGyro : kAnewRate);
  }
  if (options_.motion == MotionModel::kImu) {
    widen(StateLayout::kBiasAccel, kAnewBiasAccel);
  }
  anew.body_covariance = P;
  sound_ = anew;
  estimate_ = make_estimate(options_, given_, anew);
  steps_ns_ = t_ns;
  doubts_clock_ = clock_of_start_ = false;
  clock_opened_ns_.reset();
  calibration_ = given_;
  if (excitation_) {
    excitation_->jump();
  }
  fresh_ = WhiteSize();
  input_alarm_ = InputAlarm();
  restart_monitor();
}

void StereoFilter::restart_monitor() {
  if (monitor_) {
    monitor_.emplace(*options_.health, given_.baseline());
  }
}

}  // namespace limber
