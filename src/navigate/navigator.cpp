// SPDX-License-Identifier: MIT
#include "limber/navigate/navigator.hpp"

#include <algorithm>
#include <utility>

#include "limber/core/time.hpp"
#include "limber/measure/rig.hpp"
#include "parameter_roles.hpp"

namespace limber {

namespace {

/// Handing over for nothing costs accuracy: the alarms are set off more seldom than a monitor should be.
constexpr double kFalseHandoversPerHour = 0.01;
constexpr double kSurpriseFactor = 1.5;  // a change may be larger than what showed of it so far
constexpr double kLeastDoubt = 1.0;      // plausible errors
/// A change that large [plausible errors: 2 deg, the baseline itself] is none of a rig:
/// mismatches beside each other make it up, where few right pixels tell otherwise.
constexpr double kNoRig = 20.0;
/// Without IMU or odometry nothing but the map knows how long a metre is, and a new length of the baseline
/// can be learned from it alone: when it is that old [s], and unless the rig keeps changing.
constexpr double kMapKnowsScale = 5.0;
constexpr int kMostDoubts = 2;  // within that time
/// Older events than this [s] need not be replayed, though no window of the alarm ended meanwhile.
constexpr double kOldestCheckpoint = 5.0;
/// Frames that are replayed while one comes in: a call costs about twice an ordinary one, and five seconds
/// are caught up in two and a half.
constexpr int kReplayedFrames = 3;
/// No further frame where those replayed took that many times as long as the parallel filter's one. A frame
/// takes about as long as the square of its states.
constexpr double kMostReplayed = 4.0;
/// Where a length of the baseline cannot be learned, the filter that trusts the rig is left where its
/// innovations are that many times as large as those of the parallel one: small errors of a rig, up to three
/// times, cost it less than a scale that the parallel one knows badly.
constexpr double kFarWorse = 6.0;
constexpr double kNoFit = 2.0;            // and that many times as large as expected
constexpr double kForgetsFit = 0.9;       // per frame
constexpr double kEnoughFit = 100;        // degrees of freedom
constexpr Eigen::Index kEnoughRows = 30;  // the same, of one frame

/// Frames in a row in which most points contradict the filter but not the parallel one.
constexpr int kMostOverruled = 5;

NavigatorOptions constrained(NavigatorOptions options) {
  options.method = Method::kLcekf;
  options.constraints.kind = default_constraints(options.motion).kind;
  if (!options.health) {
    options.health = HealthOptions{};
  }
  return options;
}

HealthOptions handover_alarm() {
  HealthOptions options;
  options.false_alarms_per_hour = kFalseHandoversPerHour;
  options.most_dispersion = 1.0;  // to learn what scatters is what a doubt is for
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
  if (&answering() == &filter_) {
    filter_.add_imu(sample);
  }
}

void Navigator::add_odometry(const OdometrySample& sample) {
  if (supervision_) {
    supervision_->parallel.add_odometry(sample);
    log(sample);
  }
  if (&answering() == &filter_) {
    filter_.add_odometry(sample);
  }
}

std::int64_t Navigator::clock_offset_ns() const {
  return supervision_ ? std::max(filter_.clock_offset_ns(), supervision_->parallel.clock_offset_ns())
                      : filter_.clock_offset_ns();
}

CalibrationPrior Navigator::prior_after(const HealthReport& why) const {
  const RigParameters& delta = why.p_value < why.gathered_p_value ? why.delta : why.gathered_delta;
  CalibrationPrior out;
  out.fresh =
      (kSurpriseFactor * delta.cwiseAbs().cwiseQuotient(plausible_error(baseline_))).cwiseMax(kLeastDoubt);
  out.jump = out.fresh.cwiseAbs2().asDiagonal();
  return out;
}

/// Whether a length of the baseline that changed could be learned.
bool Navigator::knows_scale(std::int64_t t_ns) const {
  return has_scale(filter_.options().motion) ||
         (seconds_between(supervision_->began_ns, t_ns) > kMapKnowsScale &&
          supervision_->doubts < kMostDoubts);
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

/// In doubt from now on, with what the parallel filter knows.
void Navigator::take_over_from_parallel(std::int64_t t_ns) {
  Supervision& s = *supervision_;
  s.replay.reset();
  filter_.take_over(s.parallel,
                    {Eigen::Matrix<double, 6, 6>::Zero(), WhiteSize::Vector6::Constant(kLeastDoubt)});
  watch_anew(t_ns);
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

void Navigator::RecentFit::add(const FrameReport& report) {
  nis = kForgetsFit * nis + report.nis;
  dof = kForgetsFit * dof + static_cast<double>(report.dof);
}

/// Whether points tell that the cameras turned against each other so that depths are wrong. Resigned, the
/// filter trusts the rig for want of better, which costs little else.
bool Navigator::vergence_is_off() const {
  const std::shared_ptr<const CalibrationReport> known = known_calibration();
  return known &&
         known->state.axes[static_cast<std::size_t>(known->state.vergence)] == HealthVerdict::kDecalibrated;
}

void Navigator::compare_fits(const FrameReport& report, const FrameReport& parallel) {
  Supervision& s = *supervision_;
  s.own_fit.add(report);
  s.parallel_fit.add(parallel);
  const bool fits_worse = std::min(s.own_fit.dof, s.parallel_fit.dof) > kEnoughFit &&
                          s.own_fit.nis > kNoFit * s.own_fit.dof &&
                          s.own_fit.nis * s.parallel_fit.dof > kFarWorse * s.parallel_fit.nis * s.own_fit.dof;
  s.gave_up = fits_worse || (s.resigned && vergence_is_off());
  if (s.gave_up) {  // nobody will go back any more
    s.resigned = true;
    s.older.events = s.recent.events = {};
  }
}

/// The rig is not trusted from now on.
void Navigator::doubt(std::int64_t t_ns) {
  Supervision& s = *supervision_;
  ++s.doubts;
  s.doubted_ns = t_ns;
  s.trusts = false;
}

/// Whether the filter's points, but not those of the parallel one, are where a rig that is trusted cannot see
/// them.
bool Navigator::contradicts_rig(const FrameReport& report, const FrameReport& parallel) const {
  const auto fit = [](const FrameReport& of) { return of.nis / static_cast<double>(of.dof); };
  return supervision_->trusts && std::min(report.dof, parallel.dof) > kEnoughRows && fit(report) > kNoFit &&
         fit(report) > kFarWorse * fit(parallel);
}

/// The filter has begun anew, without a map, and trusts the rig as it did at first.
/// @return whether the state is now that of the parallel filter, which has not lost its own
bool Navigator::replaces_reset(const FrameReport& parallel) {
  if (!parallel.reset && knows_scale(parallel.t_ns)) {
    doubt(parallel.t_ns);
    take_over_from_parallel(parallel.t_ns);
    return true;
  }
  supervision_->trusts = true;
  watch_anew(parallel.t_ns);
  return false;
}

/// @return whether the state is now that of the parallel filter
bool Navigator::supervise(const FrameReport& report, const FrameReport& parallel) {
  Supervision& s = *supervision_;
  if (s.began_ns == 0) {
    s.began_ns = s.doubted_ns = report.t_ns;
  }
  s.overruled = report.gate_overruled && !parallel.gate_overruled ? s.overruled + 1 : 0;
  const auto judged = [](HealthMonitor& alarm, const std::optional<HealthInput>& evidence) {
    return evidence ? alarm.judge(*evidence) : HealthReport{};
  };
  if (parallel.inputs.contradiction && s.trusts) {
    // A filter that trusts the rig sees it later, and may be off by metres by then.
    filter_.follow(s.parallel);
    watch_anew(report.t_ns);
    return true;
  }
  if (parallel.inputs.contradiction) {
    filter_.distrust_inputs(*parallel.inputs.contradiction);
  }
  if (parallel.status == UpdateStatus::kUpdated && !parallel.evidence) {
    // An input fails: the rig is not to blame for what is far off, but images alone, which carry the state,
    // are no help where they do not fit it.
    if (!contradicts_rig(report, parallel) || !knows_scale(report.t_ns)) {
      return false;
    }
    doubt(report.t_ns);
    take_over_from_parallel(report.t_ns);
    return true;
  }
  const HealthReport own = judged(s.own_alarm, report.evidence);
  const HealthReport aside = judged(s.parallel_alarm, parallel.evidence);
  const bool parallel_rejects = (aside.alarm && s.trusts) || s.overruled >= kMostOverruled;
  if (seconds_between(s.doubted_ns, report.t_ns) > kMapKnowsScale) {
    s.doubts = 0;
  }
  if (!own.alarm && !parallel_rejects) {
    if (s.own_alarm.restarts() || seconds_between(s.recent.t_ns, report.t_ns) > kOldestCheckpoint) {
      s.older = std::move(s.recent);
      s.recent = {std::make_shared<const StereoFilter>(filter_), report.t_ns, {}};
    }
    return false;
  }
  if (!knows_scale(report.t_ns)) {
    s.resigned = true;
    s.older.events = s.recent.events = {};
    return false;
  }
  doubt(report.t_ns);
  const CalibrationPrior prior = prior_after(own);
  if (own.alarm && prior.fresh.maxCoeff() < kSurpriseFactor * kNoRig) {
    go_back(prior);
  } else {
    take_over_from_parallel(report.t_ns);
  }
  return true;
}

}  // namespace limber
