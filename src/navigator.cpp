// SPDX-License-Identifier: MIT
#include "limber/navigator.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_set>
#include <utility>

#include "limber/core/time.hpp"
#include "limber/map/operating_point.hpp"
#include "limber/update/gate.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double kTrustedSigma = 1e-3;  // plausible errors: theta of adaptive, as long as it trusts the rig
/// Variance that theta gains per second of walk, in variances of what is fresh in every frame: what shakes
/// may also shift, by as much from one frame to the next at 20 Hz.
constexpr double kWalkPerSecond = 20.0;

constexpr double kEstimatedWalk = 0.01;  // of the standard deviation at the start, per sqrt(s)
constexpr double kNotEstimated =
    1e-6;  // plausible errors: keeps P positive definite beside what is estimated
constexpr std::array kMoreBlocks = {ParameterBlock::kCam0, ParameterBlock::kCam1, ParameterBlock::kMount};

const ParameterSet kTheta = parameters_of(ParameterBlock::kTheta);

/// theta is in the state whatever else is estimated.
bool always_has_theta(Method method) {
  return method == Method::kEkfFull || method == Method::kConsider || method == Method::kAdaptive;
}

ParameterSet estimated(const NavigatorOptions& options) { return parameters_of(options.estimated); }
ParameterSet softened(const NavigatorOptions& options) { return parameters_of(options.softened); }

bool has_theta(const NavigatorOptions& options) {
  return always_has_theta(options.method) || (estimated(options) & kTheta).any();
}

/// theta follows its estimate from frame to frame.
bool estimates_theta(const NavigatorOptions& options) {
  return has_theta(options) && options.method != Method::kConsider;
}

bool constrains(const NavigatorOptions& options) {
  return options.method == Method::kLcekf && !options.constraints.empty();
}

bool constrains_theta(const NavigatorOptions& options) {
  return options.method == Method::kLcekf && options.constraints.has_theta();
}

bool softens(const NavigatorOptions& options) {
  return options.method == Method::kSoft || softened(options).any();
}

/// Parameters beyond theta that the filter treats as anything but known.
bool has_more(const NavigatorOptions& options) {
  const ParameterSet constrained =
      options.method == Method::kLcekf ? options.constraints.more() : ParameterSet{};
  return ((estimated(options) | softened(options) | constrained) & ~kTheta).any();
}

bool watches(const NavigatorOptions& options) {
  return options.health.has_value() && options.method != Method::kMonoLeft;
}

/// The witness lives on the rows that a constraint leaves.
bool has_witness(const NavigatorOptions& options) { return watches(options) && constrains_theta(options); }

/// How wrong ekf-full, consider and soft expect theta to be.
RigParameters theta_sigma(const NavigatorOptions& options, const StereoCalibration& calibration) {
  return options.theta_sigma.isZero() ? plausible_error(calibration.baseline()) : options.theta_sigma;
}

/// Of theta in the state, at the start.
RigParameters theta_prior(const NavigatorOptions& options, const StereoCalibration& calibration) {
  if (options.method == Method::kAdaptive) {
    return kTrustedSigma * plausible_error(calibration.baseline());
  }
  return always_has_theta(options.method)
             ? theta_sigma(options, calibration)
             : options.estimated.head<6>().cwiseMax(kNotEstimated * plausible_error(calibration.baseline()));
}

[[noreturn]] void refuse(const ParameterSet& parameters, const std::string& why) {
  std::string names;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k]) {
      names += (names.empty() ? "" : ", ") + std::string(kParameterNames[k]);
    }
  }
  throw std::invalid_argument("navigator: " + names + " " + why);
}

/// All that the gain is blind to, at least in part.
ParameterSet constrained_parameters(const NavigatorOptions& options) {
  if (!constrains(options)) {
    return {};
  }
  switch (options.constraints.kind) {
    case ConstraintSet::Kind::kListed:
      return options.constraints.listed;
    case ConstraintSet::Kind::kRotation:
      return options.constraints.more() | ParameterSet(0b111);  // ax, ay, az
    case ConstraintSet::Kind::kFull:
    case ConstraintSet::Kind::kRotationDirection:
      break;
  }
  return options.constraints.more() | kTheta;
}

void check_parameters(const NavigatorOptions& options, const StereoCalibration& calibration) {
  const auto demand_none = [](const ParameterSet& parameters, const std::string& why) {
    if (parameters.any()) {
      refuse(parameters, why);
    }
  };
  for (const ParameterVector& sigma : {options.estimated, options.softened}) {
    if (!sigma.allFinite() || sigma.minCoeff() < 0.0) {
      throw std::invalid_argument("navigator: standard deviations of parameters must be finite and positive");
    }
  }
  const ParameterSet constrained = constrained_parameters(options);
  const ParameterSet all = constrained | estimated(options) | softened(options);
  demand_none(constrained & estimated(options), "cannot be constrained and estimated at once");
  demand_none(constrained & softened(options), "cannot be constrained and softened at once");
  if (always_has_theta(options.method)) {
    demand_none(estimated(options) & kTheta, "of " + to_string(options.method) + " is in the state already");
  }
  if (options.method == Method::kSoft || options.method == Method::kAdaptive) {
    demand_none(softened(options) & kTheta, "is softened by " + to_string(options.method) + " already");
  }
  if (options.method == Method::kMonoLeft) {
    demand_none(all & (kTheta | parameters_of(ParameterBlock::kCam1)),
                "cannot be seen without the right camera");
  }
  if (calibration.body != BodyFrame::kImu) {
    demand_none(all & parameters_of(ParameterBlock::kMount),
                "cannot be wrong where the body is not an IMU but the camera rig itself");
  }
}

NavigatorOptions completed(NavigatorOptions options) {
  options.birth.kind = options.landmarks;
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

/// A column for each parameter of the set: c×k, one plausible error each.
MatrixXd unit_directions(const ParameterSet& set, const ParameterVector& scale) {
  MatrixXd out = MatrixXd::Zero(kParameters, static_cast<Index>(set.count()));
  Index column = 0;
  for (std::size_t k = 0; k < set.size(); ++k) {
    if (set[k]) {
      out(static_cast<Index>(k), column++) = scale(static_cast<Index>(k));
    }
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

/// Noise of a step in a gap between samples grows with the gap.
ImuNoise inflated(ImuNoise noise, double gap) {
  noise.gyro_density *= std::sqrt(gap);
  noise.accel_density *= std::sqrt(gap);
  return noise;
}

/// Per-sample noise as it acts over a step of dt: white, so that its variance goes with the sample interval
/// over dt.
OdometryNoise per_step(OdometryNoise noise, double sample_interval, double dt, double gap) {
  const double factor = std::sqrt(gap * (sample_interval > 0.0 ? sample_interval / dt : 1.0));
  noise.sigma_v *= factor;
  noise.sigma_omega *= factor;
  return noise;
}

}  // namespace

Navigator::Navigator(const NavigatorOptions& options, const StereoCalibration& calibration,
                     const InitialState& initial)
    : options_(completed(options)),
      given_(calibration),
      calibration_(calibration),
      scale_(plausible_error(calibration.baseline())),
      estimate_(make_estimate(options_, calibration, initial)) {
  check_parameters(options_, calibration);
  rig_ = mounted(calibration_);
  if (watches(options_)) {
    monitor_.emplace(*options_.health, calibration.baseline());
  }
}

void Navigator::add_imu(const ImuSample& sample) {
  if (options_.motion != MotionModel::kImu) {
    throw std::invalid_argument("navigator: IMU sample given, but the motion model is not kImu");
  }
  inputs_.add({sample.t_ns, sample.omega_imu, sample.accel_imu});
}

void Navigator::add_odometry(const OdometrySample& sample) {
  if (options_.motion != MotionModel::kOdometry) {
    throw std::invalid_argument("navigator: odometry sample given, but the motion model is not kOdometry");
  }
  inputs_.add({sample.t_ns, sample.v_body, sample.omega_body});
}

void Navigator::assume_theta(const RigParameters& theta) {
  if (estimate_.layout().has_theta) {
    throw std::invalid_argument("navigator: theta is part of the state and cannot be assumed");
  }
  calibration_.theta = theta;
  estimate_.theta = theta;
  rig_ = mounted(calibration_);
}

/// The cameras of a calibration on the body as it moves now.
MountedRig Navigator::mounted(const StereoCalibration& calibration) const {
  MountedRig out = mount(calibration);
  BodyMotion motion{estimate_.nav.v_world_body, omega_input_};
  if (options_.motion == MotionModel::kImu) {
    motion.omega_body -= estimate_.nav.bias_gyro;
  } else if (options_.motion == MotionModel::kConstantVelocity) {
    motion.omega_body = estimate_.nav.omega_body;
  }
  for (MountedCamera& camera : out) {
    camera.motion = motion;
    camera.with_parameters = has_more(options_);
  }
  return out;
}

void Navigator::use_estimated_calibration() {
  ParameterVector error;
  error << RigParameters::Zero(), estimate_.more;
  calibration_ = corrected(given_, error);
  calibration_.theta = estimate_.theta;
  rig_ = mounted(calibration_);
}

CalibrationEstimate Navigator::calibration_estimate() const {
  CalibrationEstimate out;
  out.parameters = estimated(options_);
  if (estimates_theta(options_) && always_has_theta(options_.method)) {
    out.parameters |= kTheta;
  }
  const StateLayout& layout = estimate_.layout();
  out.error << estimate_.theta - given_.theta, estimate_.more;
  const auto read_sigma = [&](ParameterBlock block, Index at) {
    out.sigma.segment<6>(first_of(block)) = estimate_.P.diagonal_block<6>(at).diagonal().cwiseSqrt();
  };
  if (layout.has_theta) {
    read_sigma(ParameterBlock::kTheta, layout.theta());
  }
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    if (layout.has_more[k]) {
      read_sigma(kMoreBlocks[k], layout.more(k));
    }
  }
  for (std::size_t k = 0; k < out.parameters.size(); ++k) {
    if (!out.parameters[k]) {
      out.error(static_cast<Index>(k)) = out.sigma(static_cast<Index>(k)) = 0.0;
    }
  }
  return out;
}

std::vector<InputStep> Navigator::steps_to(std::int64_t t_ns) {
  const std::int64_t begin_ns = estimate_.nav.t_ns;
  if (options_.motion != MotionModel::kConstantVelocity) {
    return inputs_.steps(begin_ns, t_ns);
  }
  InputStep step;
  step.t_end_ns = t_ns;
  step.dt = seconds_between(begin_ns, t_ns);
  return {step};
}

Transition Navigator::predict_step(const InputStep& step) {
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

void Navigator::predict_to(std::int64_t t_ns) {
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

void Navigator::walk_parameters(double dt) {
  const ParameterVector estimated_walk = (kEstimatedWalk * options_.estimated).cwiseAbs2();
  const StateLayout& layout = estimate_.layout();
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    if (layout.has_more[k]) {
      const Eigen::Matrix<double, 6, 6> walk =
          estimated_walk.segment<6>(first_of(kMoreBlocks[k])).asDiagonal();
      estimate_.P.set_diagonal_block(layout.more(k),
                                     estimate_.P.diagonal_block<6>(layout.more(k)) + walk * dt);
    }
  }
  if (!estimates_theta(options_)) {
    return;
  }
  const RigParameters fresh = kWalkPerSecond * fresh_.variance().cwiseProduct(scale_.cwiseAbs2());
  Eigen::Matrix<double, 6, 6> walk =
      (options_.method == Method::kEkfFull    ? options_.theta_walk
       : options_.method == Method::kAdaptive ? fresh
                                              : RigParameters(estimated_walk.head<6>()))
          .asDiagonal();
  if (options_.method == Method::kAdaptive && !has_scale(options_.motion)) {
    walk = without_length(walk, calibration_.theta);
  }
  const Index at = estimate_.layout().theta();
  estimate_.P.set_diagonal_block(at, estimate_.P.diagonal_block<6>(at) + walk * dt);
}

/// Where theta is trusted a newborn may believe all its pixels at once: lcekf without constraints is the ekf.
BirthMode Navigator::birth_mode() const {
  return constrains(options_) || softens(options_) || !fresh_.is_zero() ? BirthMode::kDiffuse
                                                                        : BirthMode::kClassical;
}

void Navigator::distrust(const Doubt& doubt) {
  const Index at = estimate_.layout().theta();
  Eigen::Matrix<double, 6, 6> jump = scale_.asDiagonal() * doubt.jump * scale_.asDiagonal();
  jump.diagonal() += kTrustedSigma * kTrustedSigma * scale_.cwiseAbs2();  // keeps P positive definite
  estimate_.P.set_diagonal_block(at, estimate_.P.diagonal_block<6>(at) + jump);
  fresh_.begin(doubt.fresh);
}

void Navigator::take_over(const Navigator& constrained, const Doubt& doubt) {
  estimate_ = constrained.estimate_;
  estimate_.promote_witness(constrained.treatment().watched.topRows<kBlockSize>());
  inputs_ = constrained.inputs_;
  omega_input_ = constrained.omega_input_;
  last_frame_ns_ = constrained.last_frame_ns_;
  use_estimated_calibration();
  distrust(doubt);
}

ParameterTreatment Navigator::treatment() const {
  const Index c = has_more(options_) ? kParameters : kBlockSize;
  const auto of_theta = [&](const MatrixXd& directions) {
    MatrixXd out = MatrixXd::Zero(c, directions.cols());
    out.topRows<kBlockSize>() = directions;
    return out;
  };
  ParameterTreatment out;
  MatrixXd C_theta(kBlockSize, 0);
  if (options_.method == Method::kLcekf) {
    C_theta = constraint_directions(options_.constraints, estimate_.theta);
    const MatrixXd C_more = unit_directions(options_.constraints.more(), plausible_errors(given_));
    out.nuisance = C_more.cols();
    out.constrained.resize(c, C_theta.cols() + C_more.cols());
    out.constrained << of_theta(C_theta), C_more.topRows(c);
  }
  ParameterVector white = options_.softened.cwiseAbs2();
  if (options_.method == Method::kSoft) {
    white.head<6>() = theta_sigma(options_, calibration_).cwiseAbs2();
  } else if (!fresh_.is_zero()) {
    white.head<6>() = fresh_.variance().cwiseProduct(scale_.cwiseAbs2());
  }
  if (!white.isZero(0.0)) {
    out.white_covariance = white.head(c).asDiagonal();
  }
  if (has_witness(options_)) {
    out.watched = of_theta(C_theta);
    out.witness = Witness{estimate_.layout().witness(), estimate_.witness};
  } else if (watches(options_)) {
    out.watched = of_theta(scale_.asDiagonal());
  }
  return out;
}

/// What may be wrong where a frame is linearised: F of operating_point. Of theta and what is the right
/// camera's own; the left one's pixels place the points.
MatrixXd Navigator::doubted() const {
  const Index c = has_more(options_) ? kParameters : kBlockSize;
  MatrixXd F_theta = options_.softened.head<6>().asDiagonal();
  if (options_.method == Method::kLcekf) {
    F_theta = kWidestErrors * constraint_directions(options_.constraints, estimate_.theta);
  } else if (options_.method == Method::kSoft) {
    F_theta = theta_sigma(options_, calibration_).asDiagonal();
  } else if (!fresh_.is_zero()) {
    F_theta = (kWidestErrors * scale_).asDiagonal();
  }
  ParameterVector more = options_.softened;
  if (options_.method == Method::kLcekf) {
    more += kWidestErrors *
            unit_directions(options_.constraints.more(), plausible_errors(given_)).rowwise().sum();
  }
  const Index own = first_of(ParameterBlock::kCam1);
  MatrixXd F = MatrixXd::Zero(c, F_theta.cols() + (c > kBlockSize ? kBlockSize : 0));
  F.topLeftCorner(kBlockSize, F_theta.cols()) = F_theta;
  if (c > kBlockSize) {
    F.block<kBlockSize, kBlockSize>(own, F_theta.cols()) = more.segment<kBlockSize>(own).asDiagonal();
  }
  return F;
}

Navigator::Newborn Navigator::bear(const StereoFrame& frame) {
  Newborn newborn;
  int anchor = -1;
  for (const StereoObservation& observation : frame.observations) {
    if (!observation.in_cam0 || estimate_.find(observation.track_id) != nullptr) {
      continue;
    }
    if (anchor < 0 && options_.landmarks == LandmarkKind::kInverseDepth) {
      // Where the place of the camera on the body, or its time, is estimated, the camera itself is the
      // anchor.
      const std::array<bool, 3>& has_more = estimate_.layout().has_more;
      anchor = has_more.front() || has_more.back()
                   ? estimate_.add_camera_anchor(
                         cam0_pose(rig_[0], estimate_.nav.T_world_body, estimate_.layout()))
                   : estimate_.add_anchor(rig_[0].T_cam_body.inverse());
    }
    const std::optional<UnspentRows> unspent =
        bear_landmark(estimate_, observation, rig_, options_.sigma_px, frame.t_ns, anchor, options_.birth);
    if (unspent) {
      newborn[observation.track_id] = *unspent;
    }
  }
  estimate_.drop_unused_anchor(anchor);
  return newborn;
}

void Navigator::book(const StackedFrame& stacked, const std::vector<bool>& accepted, const Newborn& newborn,
                     FrameReport& report) {
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
    // A newborn that contradicts its own frame is no landmark.
    if (newborn.contains(refusal.track_id)) {
      estimate_.remove_landmark(refusal.track_id);
    }
  }
}

void Navigator::update_with(const StereoFrame& frame, const Newborn& newborn, const ParameterVector& shift,
                            double dt, FrameReport& report) {
  StackedFrame stacked = stack_frame(estimate_, frame, rig_, options_.sigma_px, newborn, report.refused);
  if (!shift.isZero(0.0)) {
    // r = H dx + D (theta - assumed) + noise, wherever it is linearised. What is constrained does not notice;
    // what is trusted, or expected to be small (soft), is the assumed rig and not the operating point.
    stacked.measurement.residual += stacked.measurement.D * shift.head(stacked.measurement.D.cols());
  }
  std::vector<bool> accepted(stacked.track_ids.size(), true);
  if (stacked.measurement.rows() > 0) {
    const ParameterTreatment how = treatment();
    LinearMeasurement trusted = stacked.measurement;
    if (options_.gate) {
      const Innovation innovation = form_innovation(estimate_.P, stacked.measurement);
      const GateReport gated = gate(innovation, stacked.measurement.groups, how, options_.gate_probability);
      accepted = gated.accepted;
      report.gate_overruled = gated.overruled;
      for (std::size_t g = 0; g < accepted.size(); ++g) {
        if (!accepted[g]) {
          report.refused.push_back(
              {stacked.track_ids[g], RefusalReason::kGate, gated.distance[g], gated.threshold[g]});
        }
      }
      if (!gated.all_accepted()) {
        trusted = stacked.measurement.subset(accepted);
      }
    }
    const Eigen::Matrix<double, 6, 6> P_theta =
        has_theta(options_) ? estimate_.P.diagonal_block<6>(estimate_.layout().theta())
                            : Eigen::Matrix<double, 6, 6>::Zero().eval();
    UpdateReport update_report = update(estimate_.P, trusted, how);
    if (options_.method == Method::kConsider && update_report.status == UpdateStatus::kUpdated) {
      // Schmidt: the gain's theta rows are zero, so its block stays; the cross-covariances are those of the
      // EKF.
      const Index at = estimate_.layout().theta();
      estimate_.P.set_diagonal_block(at, P_theta);
      update_report.dx.segment<6>(at).setZero();
    }
    estimate_.retract(update_report.dx);
    report.status = update_report.status;
    report.nis = update_report.nis;
    report.dof = update_report.dof;
    report.rank = update_report.rank;
    if (monitor_) {
      learn_from(how, update_report, dt, report);
    }
  }
  if (estimates_theta(options_) || estimated(options_).any()) {
    use_estimated_calibration();
  }
  book(stacked, accepted, newborn, report);
}

FrameReport Navigator::process(const StereoFrame& raw) {
  check(raw, estimate_.nav.t_ns);
  const StereoFrame frame = visible(raw, options_.method);
  FrameReport report;
  report.t_ns = frame.t_ns;
  report.observed = frame.observations.size();

  const double dt = seconds_between(estimate_.nav.t_ns, frame.t_ns);
  predict_to(frame.t_ns);
  rest_and_recall(estimate_, frame, last_frame_ns_, options_.upkeep);
  options_.birth.mode = birth_mode();
  const bool bear_before = options_.birth.mode == BirthMode::kDiffuse;
  ParameterVector shift = ParameterVector::Zero();
  rig_ = mounted(calibration_);
  if (bear_before) {
    const Eigen::VectorXd off = operating_point(estimate_, frame, rig_[1], options_.sigma_px, doubted());
    shift.head(off.size()) = off;
    rig_ = mounted(corrected(calibration_, shift));
  }
  report.removed = forget_misplaced(estimate_, frame, last_frame_ns_, rig_[0], options_.upkeep);
  last_frame_ns_ = frame.t_ns;
  Newborn newborn = bear_before ? bear(frame) : Newborn{};
  update_with(frame, newborn, shift, dt, report);
  if (!bear_before) {
    newborn = bear(frame);
  }
  report.born = newborn.size();
  report.removed += keep_up(estimate_, frame.t_ns, options_.upkeep);
  return report;
}

}  // namespace limber
