// SPDX-License-Identifier: MIT
#include "limber/supervised_navigator.hpp"

#include <utility>

#include "limber/core/time.hpp"

namespace limber {

namespace {

/// Handing over for nothing costs accuracy: the watchdogs bark more seldom than a monitor should.
constexpr double kFalseHandoversPerHour = 0.01;
constexpr double kSurpriseFactor = 1.5;  // a change may be larger than what showed of it so far
constexpr double kLeastDoubt = 1.0;      // plausible errors
/// Without IMU or odometry nothing but the map knows how long a metre is, and a new length of the baseline
/// can be learned from it alone: when it is that old [s], and unless the rig keeps changing.
constexpr double kMapKnowsScale = 5.0;
constexpr int kMostDoubts = 2;  // within that time

NavigatorOptions auditors(NavigatorOptions options) {
  options.method = Method::kLcekf;
  options.constraints.kind =
      has_scale(options.motion) ? ConstraintSet::Kind::kFull : ConstraintSet::Kind::kRotationDirection;
  if (!options.health) {
    options.health = HealthOptions{};
  }
  return options;
}

HealthOptions watchdogs() {
  HealthOptions options;
  options.false_alarms_per_hour = kFalseHandoversPerHour;
  options.most_dispersion = 1.0;  // to learn what scatters is what a doubt is for
  return options;
}

}  // namespace

SupervisedNavigator::SupervisedNavigator(const NavigatorOptions& options,
                                         const StereoCalibration& calibration, const InitialState& initial)
    : baseline_(calibration.baseline()), navigator_(options, calibration, initial) {
  if (options.method == Method::kAdaptive) {
    const HealthMonitor watchdog(watchdogs(), baseline_);
    supervision_.emplace(Supervision{Navigator(auditors(options), calibration, initial),
                                     watchdog,
                                     watchdog,
                                     {navigator_, {}},
                                     {navigator_, {}},
                                     initial.nav.t_ns,
                                     initial.nav.t_ns});
  }
}

void SupervisedNavigator::log(const Event& event) {
  supervision_->older.events.push_back(event);
  supervision_->recent.events.push_back(event);
}

void SupervisedNavigator::add_imu(const ImuSample& sample) {
  navigator_.add_imu(sample);
  if (supervision_) {
    supervision_->auditor.add_imu(sample);
    log(sample);
  }
}

void SupervisedNavigator::add_odometry(const OdometrySample& sample) {
  navigator_.add_odometry(sample);
  if (supervision_) {
    supervision_->auditor.add_odometry(sample);
    log(sample);
  }
}

Doubt SupervisedNavigator::doubt(const HealthReport& why) const {
  const RigParameters& delta = why.p_value < why.gathered_p_value ? why.delta : why.gathered_delta;
  Doubt out;
  out.fresh =
      (kSurpriseFactor * delta.cwiseAbs().cwiseQuotient(plausible_error(baseline_))).cwiseMax(kLeastDoubt);
  out.jump = out.fresh.cwiseAbs2().asDiagonal();
  return out;
}

/// Whether a length of the baseline that changed could be learned.
bool SupervisedNavigator::knows_scale(std::int64_t t_ns) const {
  return has_scale(navigator_.options().motion) ||
         (seconds_between(supervision_->began_ns, t_ns) > kMapKnowsScale &&
          supervision_->doubts < kMostDoubts);
}

/// Comes again from the older checkpoint, in doubt this time.
FrameReport SupervisedNavigator::go_back(const HealthReport& why) {
  const Doubt how = doubt(why);
  const Checkpoint from = std::move(supervision_->older);
  navigator_ = from.navigator;
  navigator_.distrust(how);
  FrameReport last;
  for (const Event& event : from.events) {
    if (const auto* frame = std::get_if<StereoFrame>(&event)) {
      last = navigator_.process(*frame);
    } else if (const auto* imu = std::get_if<ImuSample>(&event)) {
      navigator_.add_imu(*imu);
    } else {
      navigator_.add_odometry(std::get<OdometrySample>(event));
    }
  }
  return last;
}

FrameReport SupervisedNavigator::process(const StereoFrame& frame) {
  FrameReport report = navigator_.process(frame);
  if (!supervision_) {
    return report;
  }
  log(frame);
  const FrameReport audit = supervision_->auditor.process(frame);
  if (!supervision_->resigned) {
    supervise(report, audit);
  }
  report.health = audit.health;
  return report;
}

void SupervisedNavigator::supervise(FrameReport& report, const FrameReport& audit) {
  Supervision& s = *supervision_;
  const auto judged = [](HealthMonitor& watchdog, const std::optional<HealthInput>& evidence) {
    return evidence ? watchdog.judge(*evidence) : HealthReport{};
  };
  const HealthReport own = judged(s.own_watchdog, report.evidence);
  const HealthReport auditors = judged(s.auditors_watchdog, audit.evidence);
  const bool auditor_alarms = auditors.alarm && s.trusts;
  if (seconds_between(s.doubted_ns, report.t_ns) > kMapKnowsScale) {
    s.doubts = 0;
  }
  if (!own.alarm && !auditor_alarms) {
    if (s.own_watchdog.restarts()) {
      s.older = std::move(s.recent);
      s.recent = {navigator_, {}};
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
    navigator_.take_over(s.auditor,
                         {Eigen::Matrix<double, 6, 6>::Zero(), WhiteSize::Vector6::Constant(kLeastDoubt)});
  }
  ++s.doubts;
  s.doubted_ns = report.t_ns;
  s.trusts = false;
  s.own_watchdog = HealthMonitor(watchdogs(), baseline_);
  s.recent = {navigator_, {}};
  s.older = s.recent;
}

}  // namespace limber
