// SPDX-License-Identifier: MIT
#include "limber/supervised_navigator.hpp"

#include <utility>

namespace limber {

namespace {

/// Handing over for nothing costs accuracy: the watchdogs bark more seldom than a monitor should.
constexpr double kFalseHandoversPerHour = 0.01;
constexpr double kSurpriseFactor = 1.5;  // a change may be larger than what showed of it so far
constexpr double kLeastDoubt = 1.0;      // plausible errors
/// Without IMU or odometry a change of the baseline's length shows against a map that knew the old one alone:
/// after that long, and if there was no other change that recently [s].
constexpr double kMapKnowsScale = 5.0;

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

NavigatorOptions auditors(NavigatorOptions options) {
  options.method = Method::kLcekf;
  options.constraints.kind = has_scale(options.motion) ? ConstraintSet::Kind::kFull
                                                       : ConstraintSet::Kind::kRotationDirection;
  if (!options.health) {
    options.health = HealthOptions{};
  }
  return options;
}

HealthOptions watchdogs() {
  HealthOptions options;
  options.false_alarms_per_hour = kFalseHandoversPerHour;
  return options;
}

}  // namespace

SupervisedNavigator::SupervisedNavigator(const NavigatorOptions& options,
                                         const StereoCalibration& calibration, const InitialState& initial)
    : scale_(plausible_error(calibration.baseline())), navigator_(options, calibration, initial) {
  if (options.method == Method::kAdaptive) {
    const HealthMonitor watchdog(watchdogs(), calibration.baseline());
    supervision_.emplace(Supervision{Navigator(auditors(options), calibration, initial), watchdog, watchdog,
                                     {navigator_, {}}, {navigator_, {}}, initial.nav.t_ns, initial.nav.t_ns});
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
  out.fresh = (kSurpriseFactor * delta.cwiseAbs().cwiseQuotient(scale_)).cwiseMax(kLeastDoubt);
  out.jump = out.fresh.cwiseAbs2().asDiagonal();
  const bool map_knows = seconds(supervision_->began_ns, why.t_ns) > kMapKnowsScale &&
                         seconds(supervision_->doubted_ns, why.t_ns) > kMapKnowsScale;
  if (!has_scale(navigator_.options().motion) && !map_knows) {
    out.jump = without_length(out.jump, navigator_.estimate().theta);
  }
  return out;
}

void SupervisedNavigator::set_checkpoints() {
  supervision_->recent = {navigator_, {}};
  supervision_->older = supervision_->recent;
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
  Supervision& s = *supervision_;
  log(frame);
  const FrameReport audit = s.auditor.process(frame);
  const std::optional<HealthReport> own =
      report.evidence ? std::optional(s.own_watchdog.judge(*report.evidence)) : std::nullopt;
  const std::optional<HealthReport> auditors =
      audit.evidence ? std::optional(s.auditors_watchdog.judge(*audit.evidence)) : std::nullopt;
  if (own && own->alarm) {
    report = go_back(*own);
    s.doubted_ns = frame.t_ns;
    s.trusts = false;
    set_checkpoints();
  } else if (auditors && auditors->alarm && s.trusts) {
    Doubt how{Eigen::Matrix<double, 6, 6>::Zero(), WhiteSize::Vector6::Constant(kLeastDoubt)};
    navigator_.take_over(s.auditor, how);
    s.doubted_ns = frame.t_ns;
    s.trusts = false;
    set_checkpoints();
  } else if (s.own_watchdog.restarts()) {
    s.older = std::move(s.recent);
    s.recent = {navigator_, {}};
  }
  report.health = audit.health;
  return report;
}

}  // namespace limber
