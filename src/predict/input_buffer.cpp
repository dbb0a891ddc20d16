// SPDX-License-Identifier: MIT
#include "limber/predict/input_buffer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "limber/core/time.hpp"

namespace limber {
namespace {

/// Samples this many usual intervals apart are a gap (one dropped sample is 2).
constexpr double kGap = 1.5;
constexpr double kIntervalUnknown = 2e7;            // [ns], taken for usual before the second sample
constexpr std::int64_t kLongestGapStep = 50000000;  // [ns]
/// Noise of samples changes faster than any motion [s].
constexpr double kSmoothing = 0.03;
/// What stays unknown in a gap is taken for white with this correlation time at most [s]: an error that lasts
/// as long as a short gap, and changes sign now and then in a long one.
constexpr double kLongestError = 1.0;

/// How sure one is of an input that was seen `away` seconds ago, for an error that lasts for `lasting`
/// seconds.
Unknown unknown(const MotionSeen& seen, const MotionPrior& prior, double away, double lasting) {
  const double spread = prior.about_the_mean ? seen.spread() : seen.rms();
  const double memory = seen.correlation(away, spread);
  return {memory, (1.0 - memory * memory) * spread * spread * std::min(lasting, kLongestError)};
}

}  // namespace

void require_next(const InputSample& sample, std::optional<std::int64_t> newest_ns) {
  const std::string what = "input sample at " + std::to_string(sample.t_ns) + " ns ";
  if (!sample.angular.allFinite() || !sample.linear.allFinite()) {
    throw std::invalid_argument(what + "is not finite");
  }
  if (newest_ns && sample.t_ns <= *newest_ns) {
    throw std::invalid_argument(what + "does not come after the one at " + std::to_string(*newest_ns) +
                                " ns");
  }
}

void InputBuffer::add(const InputSample& sample) {
  require_next(sample, samples_.empty() ? std::nullopt : std::optional(samples_.back().t_ns));
  if (!samples_.empty()) {
    // The shortest of the recent intervals, allowed to grow slowly: robust to drops.
    const double ns = static_cast<double>(sample.t_ns - samples_.back().t_ns);
    usual_interval_ns_ = usual_interval_ns_ > 0.0 ? std::min(ns, 1.02 * usual_interval_ns_) : ns;
  }
  angular_seen_.add(sample.t_ns, sample.angular);
  linear_seen_.add(sample.t_ns, sample.linear);
  Smooth smooth{sample.angular, sample.linear};
  if (!samples_.empty()) {
    const double kept = std::exp(-seconds_between(samples_.back().t_ns, sample.t_ns) / kSmoothing);
    smooth.angular += kept * (smooth_.back().angular - sample.angular);
    smooth.linear += kept * (smooth_.back().linear - sample.linear);
  }
  samples_.push_back(sample);
  smooth_.push_back(smooth);
}

std::size_t InputBuffer::first_after(std::int64_t t_ns) const {
  return static_cast<std::size_t>(
      std::upper_bound(samples_.begin(), samples_.end(), t_ns,
                       [](std::int64_t t, const InputSample& s) { return t < s.t_ns; }) -
      samples_.begin());
}

/// The inputs at t; `next` is the index of the first sample after t.
InputSample InputBuffer::at(std::int64_t t_ns, std::size_t next) const {
  if (samples_.empty()) {
    return {t_ns};
  }
  if (next == 0) {
    return samples_.front();
  }
  if (next == samples_.size()) {
    return samples_.back();
  }
  const InputSample& a = samples_[next - 1];
  const InputSample& b = samples_[next];
  const double s = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  return {t_ns, (1.0 - s) * a.angular + s * b.angular, (1.0 - s) * a.linear + s * b.linear,
          std::max(a.angular_density, b.angular_density), std::max(a.linear_density, b.linear_density)};
}

InputBuffer::Smooth InputBuffer::smooth_at(std::int64_t t_ns, std::size_t next) const {
  if (samples_.empty()) {
    return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  }
  if (next == 0 || next == samples_.size()) {
    return next == 0 ? smooth_.front() : smooth_.back();
  }
  const double s = static_cast<double>(t_ns - samples_[next - 1].t_ns) /
                   static_cast<double>(samples_[next].t_ns - samples_[next - 1].t_ns);
  const Smooth &a = smooth_[next - 1], &b = smooth_[next];
  return {(1.0 - s) * a.angular + s * b.angular, (1.0 - s) * a.linear + s * b.linear};
}

/// Time between the samples around, in usual intervals; without one of them, from where it is asked for.
double InputBuffer::gap_around(std::size_t next, std::int64_t begin_ns, std::int64_t end_ns) const {
  if (samples_.empty()) {
    return std::numeric_limits<double>::infinity();
  }
  const double usual = usual_interval_ns_ > 0.0 ? usual_interval_ns_ : kIntervalUnknown;
  const std::int64_t before_ns = next > 0 ? samples_[next - 1].t_ns : begin_ns;
  const std::int64_t after_ns = next < samples_.size() ? samples_[next].t_ns : end_ns;
  const double ratio = static_cast<double>(after_ns - before_ns) / usual;
  return ratio > kGap ? ratio : 1.0;
}

/// What is not known of a step in a gap: the further from the samples around it, the more.
void InputBuffer::doubt(InputStep& step, std::size_t next, std::int64_t begin_ns) const {
  const std::int64_t middle = begin_ns + (step.t_end_ns - begin_ns) / 2;
  constexpr double kFar = 1e9;  // [s]
  const double since = next > 0 ? seconds_between(samples_[next - 1].t_ns, middle) : kFar;
  const double until = next < samples_.size() ? seconds_between(middle, samples_[next].t_ns) : kFar;
  // Between two samples as far as from two that pull together; from one, as far as it is away.
  const double away = since * until / (since + until), lasting = std::min(since + until, kFar);
  step.angular_unknown = unknown(angular_seen_, prior_.angular, away, lasting);
  step.linear_unknown = unknown(linear_seen_, prior_.linear, away, lasting);
  step.gap = std::min(step.gap, 1e9);
}

std::vector<InputStep> InputBuffer::steps(std::int64_t begin_ns, std::int64_t end_ns) const {
  std::vector<InputStep> out;
  if (end_ns <= begin_ns) {
    return out;
  }
  std::size_t next = first_after(begin_ns);
  InputSample from = at(begin_ns, next);
  Smooth smooth_from = smooth_at(begin_ns, next);
  std::int64_t t = begin_ns;
  while (t < end_ns) {
    const double gap = gap_around(next, begin_ns, end_ns);
    const std::int64_t stop_ns = gap > 1.0 ? std::min(end_ns, t + kLongestGapStep) : end_ns;
    const bool reaches_sample = next < samples_.size() && samples_[next].t_ns <= stop_ns;
    const std::int64_t t_to = reaches_sample ? samples_[next].t_ns : stop_ns;
    const InputSample to = reaches_sample ? samples_[next] : at(t_to, next);
    InputStep step{t_to, seconds_between(t, t_to), 0.5 * (from.angular + to.angular),
                   0.5 * (from.linear + to.linear), gap};
    if (gap > 1.0) {
      doubt(step, next, t);
    }
    const Smooth smooth_to = smooth_at(t_to, next);
    step.angular_slope = (smooth_to.angular - smooth_from.angular) / step.dt;
    step.linear_slope = (smooth_to.linear - smooth_from.linear) / step.dt;
    step.angular_unknown.density += std::max(from.angular_density, to.angular_density);
    step.linear_unknown.density += std::max(from.linear_density, to.linear_density);
    out.push_back(step);
    from = to;
    smooth_from = smooth_to;
    t = t_to;
    next += reaches_sample ? 1 : 0;
  }
  return out;
}

void InputBuffer::forget_before(std::int64_t begin_ns) {
  // The sample before the beginning is still needed.
  while (samples_.size() > 1 && samples_[1].t_ns <= begin_ns) {
    samples_.pop_front();
    smooth_.pop_front();
  }
}

void InputBuffer::shift(std::int64_t by_ns) {
  for (InputSample& sample : samples_) {
    sample.t_ns += by_ns;
  }
  angular_seen_.shift(by_ns);
  linear_seen_.shift(by_ns);
}

double InputBuffer::longest_gap_s(std::int64_t begin_ns, std::int64_t end_ns) const {
  double longest = 0.0;
  std::int64_t t = begin_ns;
  for (std::size_t next = first_after(begin_ns); t < end_ns; ++next) {
    const bool last = next >= samples_.size();
    const std::int64_t from = next > 0 ? samples_[next - 1].t_ns : begin_ns;
    const std::int64_t to = last ? end_ns : samples_[next].t_ns;
    if (gap_around(next, begin_ns, end_ns) > 1.0) {
      longest = std::max(longest, seconds_between(from, to));
    }
    t = to;
  }
  return longest;
}

}  // namespace limber
