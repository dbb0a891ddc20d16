// SPDX-License-Identifier: MIT
// Navigator's `adaptive`: whether the rig is trusted, and whose state goes on.
#include <algorithm>
#include <utility>

#include "limber/core/time.hpp"
#include "limber/navigate/navigator.hpp"

namespace limber {

namespace {

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

}  // namespace

CalibrationPrior Navigator::prior_after(const HealthReport& why) const {
  const RigParameters& delta = why.p_value <= why.gathered_p_value ? why.delta : why.gathered_delta;
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

/// In doubt from now on, with what the parallel filter knows.
void Navigator::take_over_from_parallel(std::int64_t t_ns) {
  Supervision& s = *supervision_;
  s.replay.reset();
  filter_.take_over(s.parallel,
                    {Eigen::Matrix<double, 6, 6>::Zero(), WhiteSize::Vector6::Constant(kLeastDoubt)});
  watch_anew(t_ns);
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
    s.unconfirmed = s.own_alarm.is_unconfirmed() && knows_scale(report.t_ns);
    return s.unconfirmed;
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
