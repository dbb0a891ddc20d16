// SPDX-License-Identifier: MIT
#include "limber/navigate/stereo_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "check_inputs.hpp"
#include "limber/core/divergence_error.hpp"
#include "limber/core/time.hpp"
#include "limber/landmarks/landmark_initialization.hpp"
#include "limber/landmarks/map_management.hpp"
#include "limber/stack/linearization_point.hpp"
#include "parameter_roles.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using namespace detail;

namespace {

NavigatorOptions completed(NavigatorOptions options, const StereoCalibration& calibration) {
  options.doubt_odometry_mount = options.doubt_odometry_mount && can_doubt_mount(options, calibration);
  options.landmark_init.kind = options.landmarks;
  if (options.method == Method::kAdaptive) {  // it lives on what the monitor sees
    options.health = options.health.value_or(HealthOptions{});
    options.health->confirm_frames = true;  // as its alarms do, which share what is gathered
  }
  check_options(options);
  return options;
}

constexpr double kLivelierAtFirst =
    3.0;                            // than stated: a body whose motion images are to tell, until they do
constexpr double kLongFrame = 0.2;  // [s] without an image: the state was blind meanwhile
constexpr std::size_t kEnoughAlone = 10;  // points: images alone tell six degrees of freedom
constexpr int kTriangulations = 8;
constexpr double kRigSettled = 0.03;      // plausible errors
constexpr std::size_t kEnoughKnown = 10;  // landmarks: they tell at which rig a frame is linearised best

/// Larger of position and attitude, in sigmas of the prediction.
double size_of_correction(const PoseCorrection::Vector6& dx, const PoseCorrection::Matrix6& P) {
  const Eigen::Matrix<double, 6, 1> variance = P.diagonal();
  const double position = dx.head<3>().squaredNorm() / variance.head<3>().sum(),
               attitude = dx.tail<3>().squaredNorm() / variance.tail<3>().sum();
  return std::sqrt(std::max(position, attitude));
}

/// Whether of the points that both cameras see hardly one is known, but enough are new.
bool shows_mostly_new(const StereoFrame& frame, const Estimate& estimate) {
  std::size_t known = 0, fresh = 0;
  for (const StereoObservation& o : frame.observations) {
    if (o.in_cam0 && o.in_cam1) {
      ++(estimate.find(o.track_id) != nullptr ? known : fresh);
    }
  }
  return known < kEnoughKnown && fresh >= kEnoughKnown;
}

/// Whether a point is new that the right camera, which tells all other depths, does not see.
bool shows_new_to_left_alone(const StereoFrame& frame, const Estimate& estimate) {
  return std::ranges::any_of(frame.observations, [&](const StereoObservation& o) {
    return o.in_cam0 && !o.in_cam1 && estimate.find(o.track_id) == nullptr;
  });
}

/// The scale is told by accelerations, and by nothing of the rig.
bool told_by_imu_alone(const NavigatorOptions& options) {
  return options.motion == MotionModel::kImu &&
         (options.method == Method::kLcekf || options.method == Method::kMonoLeft);
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

}  // namespace

StereoFilter::StereoFilter(const NavigatorOptions& options, const StereoCalibration& calibration,
                           const InitialState& initial)
    : options_(completed(options, calibration)),
      given_(calibration),
      calibration_(calibration),
      scale_(plausible_error(calibration.baseline())),
      estimate_(make_estimate(options_, calibration, initial)),
      gate_thresholds_(options_.gate_probability),
      budget_(calibration, options_.map.points_per_update),
      inputs_(options.motion == MotionModel::kOdometry ? kOdometryPrior : kImuPrior),
      checks_(limits_of(options.motion)),
      clock_offset_ns_(initial.clock_offset_ns),
      sound_(initial),
      scale_told_(initial.scale_told || !has_scale(options.motion)) {
  check_parameters(options_, calibration);
  take_start(initial);
  if (estimate_.layout().has_map_scale && told_by_imu_alone(options_)) {
    excitation_.emplace(options_.imu_noise.accel_density);
  }
  if (options_.learn_odometry_noise && options_.motion == MotionModel::kOdometry) {
    odometry_noise_.emplace(options_.odometry_noise);
  }
  if (options_.learn_imu_noise && options_.motion == MotionModel::kImu) {
    imu_noise_.emplace(initial.imu_noise);
  }
  if (options_.learn_motion_noise && options_.motion == MotionModel::kConstantVelocity) {
    motion_noise_.emplace(ImuNoiseFactors{kLivelierAtFirst, kLivelierAtFirst});
  }
  if (options_.learn_pixel_noise) {
    pixel_noise_.emplace(options_.sigma_px, calibration);
  }
  if (watches(options_)) {
    monitor_.emplace(*options_.health, calibration.baseline());
  }
}

void StereoFilter::add_imu(const ImuSample& sample) {
  if (options_.motion != MotionModel::kImu) {
    throw std::invalid_argument("navigator: IMU sample given, but the motion model is not kImu");
  }
  add({sample.t_ns, sample.omega_imu, sample.accel_imu});
}

void StereoFilter::add_odometry(const OdometrySample& sample) {
  if (options_.motion != MotionModel::kOdometry) {
    throw std::invalid_argument("navigator: odometry sample given, but the motion model is not kOdometry");
  }
  add({sample.t_ns, sample.omega_body, sample.v_body});
  if (odometry_noise_) {
    odometry_noise_->add(sample);
  }
}

void StereoFilter::show_true_rig(const TrueRig& truth) {
  if (options_.method != Method::kOracle) {
    throw std::logic_error("navigator: the true rig is for the method oracle, not for " +
                           to_string(options_.method));
  }
  StereoCalibration as_built = calibration_;
  as_built.theta = truth.theta;
  check_calibration(as_built);
  calibration_ = as_built;
  estimate_.assume_theta(truth.theta);
}

/// Where theta is trusted a new landmark may believe all its pixels at once: lcekf without constraints is the
/// ekf. Else what theta touches is left to the same frame's update.
bool StereoFilter::initializes_before_update() const {
  return constrains(options_) || softens(options_) || !fresh_.is_zero();
}

StereoFilter::LinearizationPoint StereoFilter::choose_linearization_point(const StereoFrame& frame) const {
  LinearizationPoint out{mounted(calibration_)};
  if (initializes_before_update()) {
    const auto mounted_off = [&](const Eigen::VectorXd& off) {
      out.shift.head(off.size()) = off;
      return mounted(corrected(calibration_, out.shift));
    };
    const auto cam1_off = [&](const Eigen::VectorXd& off) { return mounted_off(off)[1]; };
    const Eigen::MatrixXd F = linearization_prior();
    if (!shows_mostly_new(frame, estimate_)) {
      out.rig = mounted_off(linearization_point(estimate_, frame, cam1_off, sigma_px(), F));
      return out;
    }
    // As in the first frame: the epipolar lines of new points tell a wrong rotation, and how far away they
    // are on their lines depends on it.
    for (int round = 0; round < kTriangulations; ++round) {
      const RigParameters before = out.shift.head<6>();
      Estimate with_new = estimate_;
      (void)initialize_landmarks(with_new, frame, out.rig);
      out.rig = mounted_off(linearization_point(with_new, frame, cam1_off, sigma_px(), F));
      if ((out.shift.head<6>() - before).cwiseQuotient(scale_).norm() < kRigSettled) {
        break;
      }
    }
  }
  return out;
}

StereoFilter::NewLandmarks StereoFilter::initialize_landmarks(Estimate& estimate, const StereoFrame& frame,
                                                              const MountedRig& rig) const {
  LandmarkInitOptions how = options_.landmark_init;
  how.mode = initializes_before_update() ? LandmarkInitMode::kDiffuse : LandmarkInitMode::kClassical;
  if (options_.method != Method::kMonoLeft && shows_new_to_left_alone(frame, estimate)) {
    guess_depth_as_in_map(estimate, rig[0], last_frame_ns_, how);
  }
  NewLandmarks new_landmarks;
  int anchor = -1;
  for (const StereoObservation& observation : frame.observations) {
    if (!observation.in_cam0 || estimate.find(observation.track_id) != nullptr) {
      continue;
    }
    if (anchor < 0 && options_.landmarks == LandmarkKind::kInverseDepth) {
      // Where the place of the camera on the body, or its time, is estimated, the camera itself is the
      // anchor.
      const std::array<bool, 3>& has_more = estimate.layout().has_more;
      anchor =
          has_more.front() || has_more.back()
              ? estimate.add_camera_anchor(cam0_pose(rig[0], estimate.nav().T_world_body, estimate.layout()))
              : estimate.add_anchor(rig[0].T_cam_body.inverse());
    }
    const std::optional<RemainingRows> remaining =
        initialize_landmark(estimate, observation, rig, sigma_px(), frame.t_ns, anchor, how);
    if (remaining) {
      new_landmarks[observation.track_id] = *remaining;
    }
  }
  estimate.drop_unused_anchor(anchor);
  return new_landmarks;
}

StackedFrame StereoFilter::stack(const Estimate& estimate, const StereoFrame& frame,
                                 const LinearizationPoint& at, const NewLandmarks& new_landmarks,
                                 FrameReport& report) const {
  StackedFrame stacked = stack_frame(estimate, frame, at.rig, sigma_px(), new_landmarks, report.refused);
  if (!at.shift.isZero(0.0)) {
    // r = H dx + D (theta - assumed) + noise, wherever it is linearised. What is constrained does not notice;
    // what is trusted, or expected to be small (soft), is the assumed rig and not the linearisation point.
    stacked.measurement.residual += stacked.measurement.D * at.shift.head(stacked.measurement.D.cols());
  }
  return stacked;
}

StereoFilter::Attempt StereoFilter::attempt(const StereoFrame& frame, const LinearizationPoint& at,
                                            const ParameterErrorModel& model, bool iterated,
                                            FrameReport& report) {
  Attempt out{.at = at};
  if (initializes_before_update()) {
    out.new_landmarks = initialize_landmarks(estimate_, frame, at.rig);  // Eqs. (29)-(32)
  }
  if (iterated) {
    auto [stacked, found] = stack_where_seen(frame, at, out.new_landmarks, model, report);
    out.stacked = std::move(stacked);
    out.lost = !found;
  } else {
    out.stacked = stack(estimate_, frame, at, out.new_landmarks, report);  // Eqs. (23)-(28)
  }
  out.seen = form_frame_innovation(estimate_.P(), out.stacked.measurement);
  out.accepted = gate_points(out.stacked, out.seen, model, report);
  return out;
}

/// Works the correction out, unless that was done before; consumes it or the frame's rows.
UpdateReport StereoFilter::correct_covariance(Attempt& attempt, const ParameterErrorModel& model) {
  if (attempt.correction) {
    estimate_.mutable_P() = attempt.correction->P;
    return std::move(attempt.correction->report);
  }
  return update(estimate_.mutable_P(), compressed(std::move(attempt.seen), attempt.accepted), model);
}

void StereoFilter::constrained_update(Attempt& attempt, const ParameterErrorModel& model, double dt,
                                      FrameReport& report) {
  if (!attempt.accepted.empty()) {
    const Eigen::Matrix<double, 6, 6> P_theta =
        has_theta(options_) ? estimate_.P().diagonal_block<6>(estimate_.layout().theta())
                            : Eigen::Matrix<double, 6, 6>::Zero().eval();
    const PoseCorrection::Matrix6 P_pose = estimate_.P().diagonal_block<6>(0);
    const std::optional<Estimate::Considered> scale = scale_to_hold();
    const Estimate::ScaleShares grows = estimate_.scale_shares();
    UpdateReport updated = correct_covariance(attempt, model);
    if (considers_theta(options_) && updated.status == UpdateStatus::kUpdated) {
      // Schmidt: the gain's theta rows are zero, so its block stays; the cross-covariances are those of the
      // EKF.
      const Index at = estimate_.layout().theta();
      estimate_.mutable_P().set_diagonal_block(at, P_theta);
      updated.dx.segment<6>(at).setZero();
    }
    if (scale && updated.status == UpdateStatus::kUpdated) {
      estimate_.hold(*scale, updated.dx);
    }
    const PoseCorrection::Matrix6 corrected_by = P_pose - estimate_.P().diagonal_block<6>(0);
    estimate_.retract(updated.dx, grows);
    report.status = updated.status;
    report.nis = updated.nis;
    report.dof = updated.dof;
    report.rank = updated.rank;
    if (updated.status == UpdateStatus::kUpdated) {
      report.correction = size_of_correction(updated.dx.head<6>(), P_pose);
      blind_turn_ = 0.0;
      const PoseCorrection correction{report.t_ns,  dt,          updated.dx.head<6>(),
                                      corrected_by, updated.nis, static_cast<double>(updated.dof)};
      learn_noise(model, updated, correction, report);
      judge_inputs(correction, report);
      notice_motion();
    }
    if (monitor_) {
      learn_from(model, updated, dt, report);
    }
  }
  if (estimates_theta(options_) || estimated(options_).any() || options_.doubt_odometry_mount) {
    use_estimated_calibration();
  }
}

FrameReport StereoFilter::process(const StereoFrame& raw) {
  const std::int64_t state_ns = started_at(raw.t_ns);
  check_frame(raw, state_ns, last_frame_ns_);
  estimate_.set_time(state_ns);
  StereoFrame seen = visible(raw, options_.method);
  FrameReport report;
  report.observed = seen.observations.size();
  moving_.leave_out_of(seen);
  const StereoFrame frame = budget_.choose(std::move(seen), estimate_, last_frame_ns_);
  report.t_ns = frame.t_ns;
  report.inputs = report_inputs(frame.t_ns);
  report.sigma_px = root_mean_square(sigma_px());
  report.imu_noise = imu_noise_      ? imu_noise_->factors()
                     : motion_noise_ ? motion_noise_->factors()
                                     : ImuNoiseFactors{};
  if (pixel_noise_) {
    pixel_noise_->see(raw);
  }
  try {
    take_in(frame, report);
  } catch (const DivergenceError&) {
    report.status = UpdateStatus::kSingularInnovation;
    report.used = 0;
    estimate_.set_time(frame.t_ns);
  }
  last_frame_ns_ = frame.t_ns;
  last_points_ns_ = report.observed > 0 ? frame.t_ns : last_points_ns_;
  has_processed_ = true;
  report.reset = report.status == UpdateStatus::kSingularInnovation || is_broken();
  if (report.reset) {
    begin_anew();
  } else {
    sound_ = {estimate_.nav(),
              estimate_.P().block(0, 0, sound_.body_covariance.rows(), sound_.body_covariance.rows())};
  }
  return report;
}

/// In equilibrium with frames of variance R a walk of R / n² keeps the variance R / n of n frames.
BearingWalk StereoFilter::bearing_walk() const {
  const double frames = pixel_noise_->telling_frames();
  return {root_mean_square(sigma_px()) / frames / calibration_.cam0.fu, frames};
}

/// The paper's steps.
void StereoFilter::take_in(const StereoFrame& frame, FrameReport& report) {
  const double dt = seconds_between(estimate_.nav().t_ns, frame.t_ns);
  // A motion that only images tell takes several frames to become clear, and so do depths: no landmark is
  // given up meanwhile.
  const bool enough = report.observed >= kEnoughAlone;
  const bool images_alone = report.inputs.status == InputStatus::kGap && dt <= kLongFrame && enough;
  const bool dark = is_after_darkness(frame.t_ns) && enough;
  const bool iterated = images_alone || dark;
  const bool was_blind = blind_turn_ > 0.0 || dt > kLongFrame;
  predict_to(frame.t_ns);  // Eqs. (4), (7)
  update_active_set(estimate_, frame, last_frame_ns_, options_.map,
                    !std::exchange(postpones_epoch_, false));  // compressed filter
  report.removed = was_blind && !iterated ? forget_after_blindness(frame) : 0;
  if (pixel_noise_ && options_.doubt_odometry_mount) {  // or what lasts would seem to tell the mount
    walk_bearings(estimate_, frame, mounted(calibration_)[0], bearing_walk());
  }
  const LinearizationPoint at = choose_linearization_point(frame);  // for Eq. (16)
  if (!iterated) {
    report.removed += forget_misplaced(estimate_, frame, last_frame_ns_, at.rig[0], options_.map);
  }
  const ParameterErrorModel model = error_model();
  Attempt to_see =
      dark ? attempt_after_darkness(frame, at, model, report) : attempt(frame, at, model, iterated, report);
  if (leads_astray(frame, model, to_see)) {
    report.led_astray = true;
    report.removed += forget(frame);
    report.refused.clear();
    report.gate_overruled = report.most_move = report.most_mismatched = false;
    to_see = attempt(frame, choose_linearization_point(frame), model, iterated, report);
  }
  constrained_update(to_see, model, dt, report);  // Eqs. (16)-(19)
  record(to_see.stacked, to_see.accepted, to_see.new_landmarks, report);
  if (!initializes_before_update()) {
    to_see.new_landmarks = initialize_landmarks(estimate_, frame, mounted(calibration_));
  }
  report.initialized = to_see.new_landmarks.size();
  moving_.note(report);
  usual_scatter_.learn(report.scatter, report.sigma_px);
  report.removed += manage_map(estimate_, frame.t_ns, options_.map);
}

}  // namespace limber
