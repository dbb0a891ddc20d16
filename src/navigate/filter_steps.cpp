// SPDX-License-Identifier: MIT
// StereoFilter's steps of biases and clock: which explain the innovations, and what they open.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "check_inputs.hpp"
#include "limber/core/time.hpp"
#include "limber/navigate/stereo_filter.hpp"
#include "parameter_roles.hpp"

namespace limber {

using Eigen::Vector3d;
using Steps = Estimate::Steps;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using namespace detail;

namespace {

/// By what a wrong rig may enlarge what steps explain: where no frame accuses it, and where one does.
constexpr double kWhereRigIsTrusted = 16.0, kWhereRigIsAccused = 60.0;
constexpr double kSmallestClock = 0.005;  // [s]: less is noise of stamps
constexpr double kCertainClock = 5.0;     // sigmas
constexpr double kOpen = 6.0;             // [s], for which it is estimated
constexpr double kLeastOpen = 0.5;        // [s]
constexpr double kExplained = 2.0;        // NIS per degree of freedom
constexpr double kKnownClock = 0.0002;    // [s]: of a clock that was open from the start

Steps of_each(double gyro, double accel, double clock) {
  Steps out;
  out << Vector3d::Constant(gyro), Vector3d::Constant(accel), clock;
  return out;
}

/// With a prior of the largest steps that are looked for.
struct BestSteps {
  Steps steps;
  Matrix7 covariance;
  double explained = 0.0;
};

BestSteps best_steps(const Estimate::SupposedSteps& seen) {
  const Steps prior = of_each(kLargestStep.gyro, kLargestStep.accel, kLargestStep.clock);
  Matrix7 weighted = seen.information;
  weighted.diagonal() += prior.cwiseAbs2().cwiseInverse();
  BestSteps out;
  out.covariance = weighted.inverse();
  out.steps = out.covariance * seen.evidence;
  out.explained = seen.evidence.dot(out.steps);
  return out;
}

/// The same if nothing but the clock stepped.
double explained_by_clock(const Estimate::SupposedSteps& seen) {
  const double evidence = seen.evidence(6), prior = 1.0 / (kLargestStep.clock * kLargestStep.clock);
  return evidence * evidence / (seen.information(6, 6) + prior);
}

}  // namespace

/// By how much a wrong rig or lens may enlarge what steps explain [-].
double StereoFilter::doubt_of_steps() const {
  if (is_blind_to_rig()) {
    return 1.0;
  }
  return seems_misled(estimate_.nav().t_ns) ? kWhereRigIsAccused : kWhereRigIsTrusted;
}

StepFit StereoFilter::fit_steps() const {
  if (!estimate_.layout().has_supposed_steps) {
    return {};
  }
  const Estimate::SupposedSteps seen = estimate_.supposed_steps();
  const BestSteps best = best_steps(seen);
  const Steps square = best.steps.cwiseAbs2() + best.covariance.diagonal().cwiseMax(0.0);
  return {best.explained,
          explained_by_clock(seen),
          doubt_of_steps(),
          {std::sqrt(square.head<3>().sum()), std::sqrt(square.segment<3>(3).sum()), std::sqrt(square(6))}};
}

/// Steps of that size: what they did to everything if they began when they are supposed to have, which is no
/// more than the innovations allow; and the biases alone, as if they began now.
void StereoFilter::open_steps(const StepSize& size) {
  const StepSize allowed = fit_steps().size;
  const double clock = clock_opened_ns_ || estimates_time_offset(options_) ? 0.0 : size.clock;
  estimate_.suppose_steps(of_each(std::min(size.gyro, allowed.gyro), std::min(size.accel, allowed.accel),
                                  std::min(clock, allowed.clock)));
  const Steps now = of_each(size.gyro, size.accel, 0.0);
  estimate_.mutable_P().set_diagonal_block(
      StateLayout::kBiasGyro, estimate_.P().diagonal_block<6>(StateLayout::kBiasGyro) +
                                  Eigen::Matrix<double, 6, 6>(now.head<6>().cwiseAbs2().asDiagonal()));
  if (clock > 0.0) {
    open_clock();
  }
  restart_steps();
}

/// The clock may have stepped: from now on its step is estimated.
void StereoFilter::open_clock() {
  clock_opened_ns_ = estimate_.nav().t_ns;
  estimate_.open_clock_step(kLargestStep.clock);
}

/// A clock that a start left open is estimated until it is known.
void StereoFilter::open_clock_of_start(const InitialState& initial) {
  if (initial.clock_sigma > 0.0 && estimate_.layout().has_supposed_steps &&
      !estimates_time_offset(options_)) {
    correlate_with_clock(estimate_, initial);
    clock_opened_ns_ = initial.nav.t_ns;
    clock_of_start_ = true;
  }
}

/// @return whether it is off by so much that one has to know
bool StereoFilter::follow_clock_of_start() {
  const Estimate::ClockStep step = estimate_.clock_step();
  const bool known = step.sigma < kKnownClock;
  const bool shows = std::abs(step.mean) > std::max(kSmallestClock, kCertainClock * step.sigma);
  if (shows || known) {
    set_clock_offset(clock_offset_ns_ + std::llround(1e9 * step.mean));
  }
  if (known) {
    clock_of_start_ = false;
    clock_opened_ns_.reset();
    restart_steps();
  }
  return shows;
}

/// Opens a clock that is in doubt once the frame behind the one that contradicted fits, and follows it for a
/// while. Things that move contradict the inputs as well, but then nothing that is open explains the points.
/// @return whether it shows that it stepped
bool StereoFilter::follow_clock(const FrameReport& report) {
  if (clock_of_start_) {
    return follow_clock_of_start();
  }
  const bool explains = report.nis < kExplained * static_cast<double>(report.dof) && !points_quarrel(report);
  if (std::exchange(doubts_clock_, false) && explains && !clock_opened_ns_ &&
      !estimates_time_offset(options_)) {
    open_clock();
  }
  if (!clock_opened_ns_) {
    return false;
  }
  const Estimate::ClockStep step = estimate_.clock_step();
  const double open_s = seconds_between(*clock_opened_ns_, estimate_.nav().t_ns);
  const bool shows = explains && open_s > kLeastOpen &&
                     std::abs(step.mean) > std::max(kSmallestClock, kCertainClock * step.sigma);
  if (shows) {
    set_clock_offset(clock_offset_ns_ + std::llround(1e9 * step.mean));
  } else if (!explains || open_s > kOpen) {
    clock_opened_ns_.reset();
    restart_steps();
  }
  return shows;
}

/// Samples are taken for so much earlier than stamped from now on.
void StereoFilter::set_clock_offset(std::int64_t offset_ns) {
  const std::int64_t earlier_ns = offset_ns - std::exchange(clock_offset_ns_, offset_ns);
  inputs_.shift(-earlier_ns);
  checks_.shift(-earlier_ns);
  estimate_.set_clock_step(0.0);
}

/// Steps begin now, if there are any; of a clock that is open something may be known yet.
void StereoFilter::restart_steps() {
  estimate_.restart_bias_steps();
  if (!clock_opened_ns_) {
    estimate_.restart_clock_step();
  }
  steps_ns_ = estimate_.nav().t_ns;
}

}  // namespace limber
