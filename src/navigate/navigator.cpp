// SPDX-License-Identifier: MIT
#include "limber/navigate/navigator.hpp"

#include <utility>

#include "limber/core/time.hpp"

namespace limber {

namespace {

/// Handing over for nothing costs accuracy: the alarms are set off more seldom than a monitor should be.
constexpr double kFalseHandoversPerHour = 0.01;
constexpr double kSurpriseFactor = 1.5;  // a change may be larger than what showed of it so far
constexpr double kLeastDoubt = 1.0;      // plausible errors
/// Without IMU or odometry nothing but the map knows how long a metre is, and a new length of the baseline
/// can be learned from it alone: when it is that old [s], and unless the rig keeps changing.
constexpr double kMapKnowsScale = 5.0;
constexpr int kMostDoubts = 2;  // within that time

NavigatorOptions constrained(NavigatorOptions options) {
  options.method = Method::kLcekf;
  options.constraints.kind =
      has_scale(options.motion) ? ConstraintSet::Kind::kFull : ConstraintSet::Kind::kRotationDirection;
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

}  // namespace

Navigator::Navigator(const NavigatorOptions& options, const StereoCalibration& calibration,
                     const InitialState& initial)
    : baseline_(calibration.baseline()), filter_(options, calibration, initial) {
  if (options.method == Method::kAdaptive) {
    const HealthMonitor alarm(handover_alarm(), baseline_);
    supervision_.emplace(Supervision{StereoFilter(constrained(options), calibration, initial),
                                     alarm,
                                     alarm,
                                     {filter_, {}},
                                     {filter_, {}},
                                     initial.nav.t_ns,
                                     initial.nav.t_ns});
  }
}

void Navigator::log(const Event& event) {
  supervision_->older.events.push_back(event);
  supervision_->recent.events.push_back(event);
}

void Navigator::add_imu(const ImuSample& sample) {
  filter_.add_imu(sample);
  if (supervision_) {
    supervision_->parallel.add_imu(sample);
    log(sample);
  }
}

void Navigator::add_odometry(const OdometrySample& sample) {
  filter_.add_odometry(sample);
  if (supervision_) {
    supervision_->parallel.add_odometry(sample);
    log(sample);
  }
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
FrameReport Navigator::go_back(const HealthReport& why) {
  const CalibrationPrior prior = prior_after(why);
  const Checkpoint from = std::move(supervision_->older);
  filter_ = from.filter;
  filter_.distrust(prior);
  FrameReport last;
  for (const Event& event : from.events) {
    if (const auto* frame = std::get_if<StereoFrame>(&event)) {
      last = filter_.process(*frame);
    } else if (const auto* imu = std::get_if<ImuSample>(&event)) {
      filter_.add_imu(*imu);
    } else {
      filter_.add_odometry(std::get<OdometrySample>(event));
    }
  }
  return last;
}

FrameReport Navigator::process(const StereoFrame& frame) {
  FrameReport report = filter_.process(frame);
  if (!supervision_) {
    health_ = report.health;
    return report;
  }
  log(frame);
  const FrameReport parallel = supervision_->parallel.process(frame);
  if (!supervision_->resigned) {
    supervise(report, parallel);
  }
  report.health = health_ = parallel.health;
  return report;
}

void Navigator::supervise(FrameReport& report, const FrameReport& parallel) {
  Supervision& s = *supervision_;
  const auto judged = [](HealthMonitor& alarm, const std::optional<HealthInput>& evidence) {
    return evidence ? alarm.judge(*evidence) : HealthReport{};
  };
  const HealthReport own = judged(s.own_alarm, report.evidence);
  const HealthReport aside = judged(s.parallel_alarm, parallel.evidence);
  const bool parallel_rejects = aside.alarm && s.trusts;
  if (seconds_between(s.doubted_ns, report.t_ns) > kMapKnowsScale) {
    s.doubts = 0;
  }
  if (!own.alarm && !parallel_rejects) {
    if (s.own_alarm.restarts()) {
      s.older = std::move(s.recent);
      s.recent = {filter_, {}};
    }
    return;
  }
  if (!knows_scale(report.t_ns)) {
    s.resigned = true;
    return;
  }
  if (own.alarm) {
    report = go_back(own);
  } else {
    filter_.take_over(s.parallel,
                      {Eigen::Matrix<double, 6, 6>::Zero(), WhiteSize::Vector6::Constant(kLeastDoubt)});
  }
  ++s.doubts;
  s.doubted_ns = report.t_ns;
  s.trusts = false;
  s.own_alarm = HealthMonitor(handover_alarm(), baseline_);
  s.recent = {filter_, {}};
  s.older = s.recent;
}

}  // namespace limber
