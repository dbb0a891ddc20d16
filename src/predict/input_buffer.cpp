// SPDX-License-Identifier: MIT
#include "limber/predict/input_buffer.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace limber {
namespace {

/// Samples this many usual intervals apart are a gap (one dropped sample is 2).
constexpr double kGap = 1.5;

}  // namespace

void InputBuffer::add(const InputSample& sample) {
  if (!sample.first.allFinite() || !sample.second.allFinite()) {
    throw std::invalid_argument("input sample at " + std::to_string(sample.t_ns) + " ns is not finite");
  }
  if (!samples_.empty()) {
    const std::int64_t interval = sample.t_ns - samples_.back().t_ns;
    if (interval <= 0) {
      throw std::invalid_argument("input sample at " + std::to_string(sample.t_ns) +
                                  " ns does not come after the one at " +
                                  std::to_string(samples_.back().t_ns) + " ns");
    }
    // The shortest of the recent intervals, allowed to grow slowly: robust to drops.
    const double ns = static_cast<double>(interval);
    usual_interval_ns_ = usual_interval_ns_ > 0.0 ? std::min(ns, 1.02 * usual_interval_ns_) : ns;
  }
  samples_.push_back(sample);
}

/// The inputs at t; `next` is the index of the first sample after t.
InputSample InputBuffer::at(std::int64_t t_ns, std::size_t next) const {
  if (next == 0) {
    return samples_.front();
  }
  if (next == samples_.size()) {
    return samples_.back();
  }
  const InputSample& a = samples_[next - 1];
  const InputSample& b = samples_[next];
  const double s = static_cast<double>(t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
  return {t_ns, (1.0 - s) * a.first + s * b.first, (1.0 - s) * a.second + s * b.second};
}

double InputBuffer::gap_around(std::size_t next, std::int64_t end_ns) const {
  if (next == 0 || usual_interval_ns_ == 0.0) {
    return 1.0;
  }
  const std::int64_t after_ns = next < samples_.size() ? samples_[next].t_ns : end_ns;
  const double ratio = static_cast<double>(after_ns - samples_[next - 1].t_ns) / usual_interval_ns_;
  return ratio > kGap ? ratio : 1.0;
}

std::vector<InputStep> InputBuffer::steps(std::int64_t begin_ns, std::int64_t end_ns) {
  std::vector<InputStep> out;
  if (samples_.empty() || end_ns <= begin_ns) {
    return out;
  }
  std::size_t next = static_cast<std::size_t>(
      std::upper_bound(samples_.begin(), samples_.end(), begin_ns,
                       [](std::int64_t t, const InputSample& s) { return t < s.t_ns; }) -
      samples_.begin());
  InputSample from = at(begin_ns, next);
  std::int64_t t = begin_ns;
  while (t < end_ns) {
    const bool reaches_sample = next < samples_.size() && samples_[next].t_ns <= end_ns;
    const std::int64_t t_to = reaches_sample ? samples_[next].t_ns : end_ns;
    const InputSample to = reaches_sample ? samples_[next] : at(t_to, next);
    InputStep step{t_to, 1e-9 * static_cast<double>(t_to - t), 0.5 * (from.first + to.first),
                   0.5 * (from.second + to.second), 1.0};
    step.gap = gap_around(next, end_ns);
    out.push_back(step);
    from = to;
    t = t_to;
    next += reaches_sample ? 1 : 0;
  }
  // The sample before the end is still needed for the next step.
  while (samples_.size() > 1 && samples_[1].t_ns <= end_ns) {
    samples_.pop_front();
  }
  return out;
}

}  // namespace limber
