// SPDX-License-Identifier: MIT
#include "limber/navigate/navigator.hpp"

#include <algorithm>

#include "limber/measure/rig.hpp"
#include "parameter_roles.hpp"

namespace limber {

namespace {

/// Handing over for nothing costs accuracy: the alarms are set off more seldom than a monitor should be.
constexpr double kFalseHandoversPerHour = 0.01;
/// Frames that are replayed while one comes in: a call costs about twice an ordinary one, and five seconds
/// are caught up in two and a half.
constexpr int kReplayedFrames = 3;
/// No further frame where those replayed took that many times as long as the parallel filter's one. A frame
/// takes about as long as the square of its states.
constexpr double kMostReplayed = 4.0;
NavigatorOptions constrained(NavigatorOptions options) {
  options.method = Method::kLcekf;
  options.constraints.kind = default_constraints(options.motion).kind;
  options.health = options.health.value_or(HealthOptions{});
  options.health->confirm_frames = true;
  return options;
}

HealthOptions handover_alarm() {
  HealthOptions options;
  options.false_alarms_per_hour = kFalseHandoversPerHour;
  options.most_dispersion = 1.0;  // to learn what scatters is what a doubt is for
  options.confirm_frames = true;
  return options;
}

/// Whether an epoch of the map ended in the filter's last frame.
bool ends_epoch(const StereoFilter& filter) {
  return filter.estimate().epoch_began_ns() == filter.estimate().nav().t_ns;
}

/// What a velocity says of the length of a metre.
TrajectoryQuality quality_of(const Eigen::Vector3d& velocity, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d along = velocity.stableNormalized();
  return {true, covariance.isZero(0.0) ? 0.0 : velocity.squaredNorm(), along.dot(covariance * along)};
}

double squared_size(const StereoFilter& filter) {
  const auto n = static_cast<double>(filter.estimate().size());
  return n * n;
}

}  // namespace

Navigator::Navigator(const NavigatorOptions& options, const StereoCalibration& calibration,
                     const InitialState& initial)
    : baseline_(calibration.baseline()),
      T_body_cam0_(mount(calibration)[0].T_cam_body.inverse()),
      filter_(options, calibration, initial) {
  if (detail::watches(options)) {
    WatchOptions how = options.verdict;
    how.false_alarms_per_hour = options.health->false_alarms_per_hour;
    watch_.emplace(how, calibration, has_scale(options.motion));
  }
  if (options.method == Method::kAdaptive) {
    const HealthMonitor alarm(handover_alarm(), baseline_);
    const InitialState& blind = initial.distrusting ? *initial.distrusting : initial;
    const Checkpoint begin{
        std::make_shared<const StereoFilter>(options, calibration, blind), initial.nav.t_ns, {}};
    supervision_.emplace(Supervision{StereoFilter(constrained(options), calibration, blind), alarm, alarm,
                                     begin, begin, initial.nav.t_ns, initial.nav.t_ns});
  }
}

void Navigator::reset(const InitialState& initial) {
  *this = Navigator(filter_.options(), filter_.given_calibration(), initial);
}

void Navigator::log(const Event& event) {
  Supervision& s = *supervision_;
  if (s.replay) {
    s.replay->push_back(event);
  } else if (!s.resigned) {
    s.older.events.push_back(event);
    s.recent.events.push_back(event);
  }
}

std::size_t Navigator::events_kept() const {
  if (!supervision_) {
    return 0;
  }
  const Supervision& s = *supervision_;
  return s.older.events.size() + s.recent.events.size() + (s.replay ? s.replay->size() : 0);
}

void Navigator::add_imu(const ImuSample& sample) {
  if (supervision_) {
    supervision_->parallel.add_imu(sample);
    log(sample);
  }
  if (filter_keeps_up()) {
    filter_.add_imu(sample);
  }
}

void Navigator::add_odometry(const OdometrySample& sample) {
  if (supervision_) {
    supervision_->parallel.add_odometry(sample);
    log(sample);
  }
  if (filter_keeps_up()) {
    filter_.add_odometry(sample);
  }
}

std::int64_t Navigator::clock_offset_ns() const {
  return supervision_ ? std::max(filter_.clock_offset_ns(), supervision_->parallel.clock_offset_ns())
                      : filter_.clock_offset_ns();
}

/// Comes again from the older checkpoint, in doubt this time.
void Navigator::go_back(const CalibrationPrior& prior) {
  Supervision& s = *supervision_;
  filter_ = *s.older.filter;
  filter_.distrust(prior);
  s.replay.emplace(s.older.events.begin(), s.older.events.end());
  s.older.events.clear();
  s.recent.events.clear();
}

/// Some of what the filter has not seen yet; once that is all, it answers again. Where an epoch of the map
/// ends, here or in the filter beside, one frame is enough for a call, and one epoch.
void Navigator::replay() {
  Supervision& s = *supervision_;
  int left = ends_epoch(s.parallel) ? 1 : kReplayedFrames;
  double work = kMostReplayed * squared_size(s.parallel);
  for (bool may_end = !ends_epoch(s.parallel); left > 0 && !s.replay->empty(); s.replay->pop_front()) {
    const Event& event = s.replay->front();
    if (const auto* frame = std::get_if<StereoFrame>(&event)) {
      if (!may_end) {
        filter_.postpone_epoch();
      }
      may_end = false;
      (void)filter_.process(*frame);
      work -= squared_size(filter_);
      left = ends_epoch(filter_) || work < 0.0 ? 0 : left - 1;
    } else if (const auto* imu = std::get_if<ImuSample>(&event)) {
      filter_.add_imu(*imu);
    } else {
      filter_.add_odometry(std::get<OdometrySample>(event));
    }
  }
  if (s.replay->empty()) {
    s.replay.reset();
    watch_anew(filter_.estimate().nav().t_ns);
  }
}

/// The filter has another state than a frame before: nothing earlier counts, and it goes no further back.
void Navigator::watch_anew(std::int64_t t_ns) {
  supervision_->overruled = 0;
  supervision_->own_alarm = HealthMonitor(handover_alarm(), baseline_);
  supervision_->recent = {std::make_shared<const StereoFilter>(filter_), t_ns, {}};
  supervision_->older = supervision_->recent;
}

std::shared_ptr<const CalibrationReport> Navigator::watch_earlier(const StereoFrame& frame,
                                                                  const NavigationState& nav,
                                                                  const Eigen::Matrix3d& velocity) {
  if (watch_) {
    watch_->add(frame, nav.T_world_body * T_body_cam0_, quality_of(nav.v_world_body, velocity));
  }
  return known_calibration();
}

/// The calibration, judged from where the filter that it cannot lead astray (if there is one) says it was.
void Navigator::watch(const StereoFrame& frame, const StereoFilter& filter, const FrameReport& report) {
  if (!watch_) {
    return;
  }
  const Estimate& estimate = filter.estimate();
  TrajectoryQuality quality;
  if (filter.options().motion != MotionModel::kOdometry) {
    quality = quality_of(estimate.nav().v_world_body, estimate.P().diagonal_block<3>(StateLayout::kVelocity));
  }
  quality.sound =
      report.status == UpdateStatus::kUpdated && !report.reset && !report.inputs.contradiction &&
      (report.inputs.status == InputStatus::kSound || report.inputs.status == InputStatus::kNotNeeded);
  const Pose T_body_cam0 = body_from_cam0(filter.calibration());  // where it may have turned
  watch_->add(frame, estimate.nav().T_world_body * T_body_cam0, quality);
}

std::shared_ptr<const CalibrationReport> Navigator::known_calibration() const {
  return watch_ ? watch_->report() : nullptr;
}

FrameReport Navigator::process(const StereoFrame& frame) {
  if (!supervision_) {
    FrameReport report = filter_.process(frame);
    health_ = report.health;
    watch(frame, filter_, report);
    report.calibration = known_calibration();
    return report;
  }
  Supervision& s = *supervision_;
  FrameReport parallel = s.parallel.process(frame);  // refuses a frame before anything has changed
  s.unconfirmed = false;
  health_ = parallel.health;
  watch(frame, s.parallel, parallel);
  parallel.calibration = known_calibration();
  log(frame);
  filter_.share_imu_noise(s.parallel);
  if (s.replay && parallel.inputs.contradiction) {
    // What is replayed has an input in it that fails, which the parallel filter saw and this one would
    // follow.
    take_over_from_parallel(parallel.t_ns);
    return parallel;
  }
  if (s.replay) {
    replay();
    return parallel;
  }
  if (s.gave_up) {
    return parallel;
  }
  if (ends_epoch(s.parallel)) {
    filter_.postpone_epoch();
  }
  FrameReport report = filter_.process(frame);
  if (report.reset && !s.resigned && replaces_reset(parallel)) {
    return parallel;
  }
  if (!s.resigned && supervise(report, parallel)) {
    return parallel;
  }
  if (!s.replay && (s.resigned || !knows_scale(report.t_ns))) {
    compare_fits(report, parallel);
  }
  if (parallel.inputs.contradiction) {  // which a filter that trusts the rig may not see
    report.inputs.status = std::max(report.inputs.status, parallel.inputs.status);
    report.inputs.contradiction = parallel.inputs.contradiction;
  }
  if (s.replay || s.gave_up) {
    return parallel;
  }
  report.health = health_;
  report.calibration = parallel.calibration;
  return report;
}

}  // namespace limber
