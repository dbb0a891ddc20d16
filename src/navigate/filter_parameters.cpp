// SPDX-License-Identifier: MIT
// StereoFilter's calibration: which part of it is in the state, how it walks, and what an update makes of the
// rest.
#include "limber/navigate/stereo_filter.hpp"

#include <cmath>

#include "parameter_roles.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using namespace detail;

namespace {

/// Variance that theta gains per second of walk, in variances of what is fresh in every frame: what shakes
/// may also shift, by as much from one frame to the next at 20 Hz.
constexpr double kWalkPerSecond = 20.0;

constexpr double kEstimatedWalk = 0.01;  // of the standard deviation at the start, per sqrt(s)

constexpr double kMountLasts = 0.3;  // [s] of an odometer's mount that is in doubt

constexpr double kPaperBaseline = 2.0;  // [m]
constexpr double kPaperWalk = 1e-4;     // per second: 1e-6 [rad^2], [m^2] per 10 ms, Table 1

}  // namespace

RigParameters default_theta_walk(double baseline) {
  const double share = baseline / kPaperBaseline;
  RigParameters walk = RigParameters::Constant(kPaperWalk);
  walk.tail<3>() *= share * share;
  return walk;
}

/// The cameras of a calibration on the body as it moves now.
MountedRig StereoFilter::mounted(const StereoCalibration& calibration) const {
  MountedRig out = mount(calibration);
  BodyMotion motion{estimate_.nav().v_world_body, omega_input_};
  if (options_.motion == MotionModel::kImu) {
    motion.omega_body -= estimate_.nav().bias_gyro;
  } else if (options_.motion == MotionModel::kConstantVelocity) {
    motion.omega_body = estimate_.nav().omega_body;
  }
  for (MountedCamera& camera : out) {
    camera.motion = motion;
    camera.with_parameters = has_more(options_);
  }
  return out;
}

/// What was given, with what an estimate has of it.
StereoCalibration StereoFilter::calibration_of(const Estimate& estimate) const {
  ParameterVector error;
  error << RigParameters::Zero(), estimate.more();
  StereoCalibration out = corrected(given_, error);
  out.theta = estimate.theta();
  return out;
}

void StereoFilter::use_estimated_calibration() { calibration_ = calibration_of(estimate_); }

CalibrationEstimate StereoFilter::calibration_estimate() const {
  CalibrationEstimate out;
  out.parameters = estimated(options_);
  if (estimates_theta(options_) && always_has_theta(options_.method)) {
    out.parameters |= theta_parameters();
  }
  out.trusts_rig = options_.method == Method::kAdaptive && fresh_.is_zero();
  const StateLayout& layout = estimate_.layout();
  out.error << estimate_.theta() - given_.theta, estimate_.more();
  const auto read_sigma = [&](ParameterBlock block, Index at) {
    out.sigma.segment<6>(first_of(block)) = estimate_.P().diagonal_block<6>(at).diagonal().cwiseSqrt();
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

/// The angles of a mount that is in doubt tend to nothing, and as much of fresh ones comes in: their sigmas
/// stay (Gauss-Markov of first order).
void StereoFilter::renew_mount(double dt) {
  const double kept = std::exp(-dt / kMountLasts);
  estimate_.shrink_mount_rotation(kept);
  const Index at = estimate_.layout().more(kMoreBlocks.size() - 1);
  Eigen::Matrix<double, 6, 6> P = estimate_.P().diagonal_block<6>(at);
  const Eigen::Vector3d sigma = mount_sigma(given_);
  P.diagonal().head<3>() += ((1.0 - kept * kept) * sigma).cwiseProduct(sigma);
  estimate_.mutable_P().set_diagonal_block(at, P);
  use_estimated_calibration();
}

void StereoFilter::walk_parameters(double dt) {
  if (options_.doubt_odometry_mount) {
    renew_mount(dt);
  }
  const ParameterVector estimated_walk = (kEstimatedWalk * options_.estimated).cwiseAbs2();
  const StateLayout& layout = estimate_.layout();
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    if (layout.has_more[k]) {
      const Eigen::Matrix<double, 6, 6> walk =
          estimated_walk.segment<6>(first_of(kMoreBlocks[k])).asDiagonal();
      estimate_.mutable_P().set_diagonal_block(layout.more(k),
                                               estimate_.P().diagonal_block<6>(layout.more(k)) + walk * dt);
    }
  }
  if (!estimates_theta(options_)) {
    return;
  }
  const RigParameters fresh = kWalkPerSecond * fresh_.variance().cwiseProduct(scale_.cwiseAbs2());
  Eigen::Matrix<double, 6, 6> walk =
      (options_.method == Method::kEkfFull
           ? options_.theta_walk.value_or(default_theta_walk(given_.baseline()))
       : options_.method == Method::kAdaptive ? fresh
                                              : RigParameters(estimated_walk.head<6>()))
          .asDiagonal();
  if (options_.method == Method::kAdaptive && !tells_length()) {
    walk = without_length(walk, calibration_.theta);
  }
  const Index at = estimate_.layout().theta();
  estimate_.mutable_P().set_diagonal_block(at, estimate_.P().diagonal_block<6>(at) + walk * dt);
}

void StereoFilter::distrust(const CalibrationPrior& prior) {
  const Index at = estimate_.layout().theta();
  Eigen::Matrix<double, 6, 6> jump = scale_.asDiagonal() * prior.jump * scale_.asDiagonal();
  if (!scale_told_) {  // the length would be learned from a map whose scale is as unknown
    jump = without_length(jump, calibration_.theta);
  }
  jump.diagonal() += kTrustedSigma * kTrustedSigma * scale_.cwiseAbs2();  // keeps P positive definite
  estimate_.mutable_P().set_diagonal_block(at, estimate_.P().diagonal_block<6>(at) + jump);
  fresh_.begin(prior.fresh);
}

void StereoFilter::copy_state(const StereoFilter& constrained) {
  estimate_ = constrained.estimate_;
  sound_ = constrained.sound_;
  blind_turn_ = constrained.blind_turn_;
  moving_ = constrained.moving_;
  usual_scatter_ = constrained.usual_scatter_;
  inputs_ = constrained.inputs_;
  checks_ = constrained.checks_;
  input_alarm_ = constrained.input_alarm_;
  steps_ns_ = constrained.steps_ns_;
  doubts_clock_ = constrained.doubts_clock_;
  clock_opened_ns_ = constrained.clock_opened_ns_;
  clock_of_start_ = constrained.clock_of_start_;
  clock_offset_ns_ = constrained.clock_offset_ns_;
  distrust_ = constrained.distrust_;
  trusted_again_ns_ = constrained.trusted_again_ns_;
  omega_input_ = constrained.omega_input_;
  pixel_noise_ = constrained.pixel_noise_;
  rig_accused_ns_ = constrained.rig_accused_ns_;
  scale_told_ = constrained.scale_told_;
  last_frame_ns_ = constrained.last_frame_ns_;
  last_points_ns_ = constrained.last_points_ns_;
}

/// The first map, and what body and points owe to what is not known exactly.
void StereoFilter::take_start(const InitialState& initial) {
  // Points would have to be correlated with what more is in doubt: with what is estimated the start does so.
  if (!has_more(options_) || (initial.by_parameters.size() > 0 && doubts_by_estimating(options_))) {
    place_first_map(estimate_, initial, mount(given_)[0].T_cam_body.inverse());
    correlate_with_parameters(estimate_, initial);
  }
  open_clock_of_start(initial);
  if (!estimate_.landmarks().empty()) {
    last_frame_ns_ = initial.nav.t_ns;
    rest_unseen(estimate_, initial.nav.t_ns, options_.map);
  }
}

void StereoFilter::take_over(const StereoFilter& constrained, const CalibrationPrior& prior) {
  if (constrained.scale_told_) {
    copy_state(constrained);
    estimate_.promote_witness(constrained.error_model().watched.topRows<kBlockSize>());
    use_estimated_calibration();
  } else {
    follow(constrained);  // its witness compares the length to a scale that nobody knows
  }
  distrust(prior);
}

void StereoFilter::follow(const StereoFilter& constrained) {
  copy_state(constrained);
  estimate_.restart_witness(kTrustedSigma);
  estimate_.promote_witness(constrained.error_model().watched.topRows<kBlockSize>());
  const RigParameters trusted = kTrustedSigma * kTrustedSigma * scale_.cwiseAbs2();
  estimate_.mutable_P().set_diagonal_block(estimate_.layout().theta(),
                                           Eigen::Matrix<double, 6, 6>(trusted.asDiagonal()));
  use_estimated_calibration();
}

ParameterErrorModel StereoFilter::error_model() const {
  const Index c = has_more(options_) ? kParameters : kBlockSize;
  const auto of_theta = [&](const MatrixXd& directions) {
    MatrixXd out = MatrixXd::Zero(c, directions.cols());
    out.topRows<kBlockSize>() = directions;
    return out;
  };
  ParameterErrorModel out;
  MatrixXd C_theta(kBlockSize, 0);
  if (options_.method == Method::kLcekf) {
    C_theta = constraint_directions(options_.constraints, estimate_.theta());
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
    out.witness = Witness{estimate_.layout().witness(), estimate_.witness()};
  } else if (watches(options_)) {
    out.watched = of_theta(scale_.asDiagonal());
  }
  return out;
}

/// What may be wrong where a frame is linearised: F of linearization_point. Of theta and what is the right
/// camera's own; the left one's pixels place the points.
MatrixXd StereoFilter::linearization_prior() const {
  const Index c = has_more(options_) ? kParameters : kBlockSize;
  MatrixXd F_theta = options_.softened.head<6>().asDiagonal();
  if (options_.method == Method::kLcekf) {
    F_theta = kWidestErrors * constraint_directions(options_.constraints, estimate_.theta());
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

}  // namespace limber
