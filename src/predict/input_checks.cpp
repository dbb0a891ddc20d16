// SPDX-License-Identifier: MIT
#include "limber/predict/input_checks.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/time.hpp"

namespace limber {
namespace {

constexpr std::size_t kRepeats = 2;        // in a row: more is stuck (some drivers hand out samples twice)
constexpr double kUsualRepeats = 0.05;     // of the samples that vary
constexpr std::size_t kVaried = 20;        // samples before a stream is known to vary
constexpr double kUsualJump = 12.0;        // times the mean change between samples
constexpr double kBack = 0.5;              // of the jump: then the next sample is back where it was
constexpr double kUsualShare = 0.01;       // of one sample in the mean change
constexpr double kLongestNeighbour = 0.1;  // [s]: further apart, samples are no neighbours
constexpr double kEndOfRange = 0.999;      // of the largest value seen
constexpr std::size_t kPlateau = 2;        // repeats of it in a row
constexpr double kOvershoot = 0.5;         // of the range: what a saturated sensor may have missed, at least

const Eigen::Vector3d& part(const InputSample& sample, std::size_t k) {
  return k == 0 ? sample.angular : sample.linear;
}

double change(const InputSample& a, const InputSample& b, std::size_t k) {
  return (part(a, k) - part(b, k)).norm();
}

void raise_density(InputSample& sample, std::size_t k, double to) {
  double& density = k == 0 ? sample.angular_density : sample.linear_density;
  density = std::max(density, to);
}

}  // namespace

bool InputFaultCounts::any() const {
  return std::any_of(count.begin(), count.end(), [](std::size_t n) { return n > 0; });
}

InputFaultCounts InputChecks::take_counts() { return std::exchange(counts_, {}); }

void InputChecks::shift(std::int64_t by_ns) {
  newest_ns_ += by_ns;
  for (std::optional<InputSample>* sample : {&last_, &held_}) {
    if (*sample) {
      (*sample)->t_ns += by_ns;
    }
  }
}

/// Six floating point numbers that all repeat themselves twice are no measurement of anything that moves.
bool InputChecks::is_stuck(const Six& value) {
  if (limits_.rests_at_zero && value.isZero(0.0)) {
    repeats_ = 0;
    return false;
  }
  if (value == value_) {
    ++repeats_;
    repeated_ += repeats_ <= kRepeats ? 1 : 0;  // what is stuck once repeats itself for long
  } else {
    repeats_ = 0;
    ++varied_;
  }
  return repeats_ >= kRepeats && varied_ > kVaried && !counts_steps();
}

/// Encoders count whole steps, so that values repeat themselves.
bool InputChecks::counts_steps() const {
  const auto earlier = static_cast<double>(repeated_ - std::min(repeats_, kRepeats));
  return limits_.rests_at_zero && earlier > kUsualRepeats * static_cast<double>(varied_);
}

bool InputChecks::jumps(const InputSample& from, const InputSample& to, std::size_t k, double limit) const {
  return varied_ > kVaried && seconds_between(from.t_ns, to.t_ns) <= kLongestNeighbour &&
         change(from, to, k) > std::max(limit, kUsualJump * usual_change_[k]);
}

/// A jolt of the body, or a spike too small to be left out: its noise is of its size. While one was held
/// back, frames may have gone by without it.
void InputChecks::doubt_jolt(InputSample& sample, double dt) const {
  for (std::size_t k = 0; k < 2; ++k) {
    if (jumps(*last_, sample, k, limits_.doubted_jump[k])) {
      const double size = change(*last_, sample, k);
      raise_density(sample, k, size * size * dt);
    }
  }
}

/// The largest value that an axis ever had in that direction, several times in a row to the last digit: the
/// end of the sensor's range. An offset that was taken off afterwards makes the ends of a range differ.
void InputChecks::doubt_saturated(InputSample& sample, double dt) {
  bool saturated = false;
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Array3d value = part(sample, k);
    Ends size;
    size << value, -value;
    peaks_[k] = peaks_[k].max(size);
    const Eigen::Array3d at_end =
        (size >= kEndOfRange * peaks_[k] && size > limits_.saturation[k]).cast<double>().rowwise().maxCoeff();
    const bool flat = !counts_steps() && last_ && (value == part(*last_, k).array() && at_end > 0.0).any() &&
                      usual_change_[k] > 0.0;
    const double peak = peaks_[k].maxCoeff();
    plateau_[k] = flat ? plateau_[k] + 1 : 0;
    if (plateau_[k] >= kPlateau) {
      saturated = true;
      const auto length = static_cast<double>(plateau_[k]);
      const double missed = kOvershoot * peak + length * usual_change_[k];
      raise_density(sample, k, missed * missed * length * dt);
    }
  }
  counts_[InputFault::kSaturated] += saturated ? 1 : 0;
}

void InputChecks::accept(InputSample sample, InputBuffer& buffer) {
  if (last_) {
    const double dt = seconds_between(last_->t_ns, sample.t_ns);
    doubt_jolt(sample, dt);
    doubt_saturated(sample, dt);
    if (dt <= kLongestNeighbour) {
      for (std::size_t k = 0; k < 2; ++k) {
        const double share = std::max(kUsualShare, 1.0 / static_cast<double>(varied_ + 1));
        usual_change_[k] += share * (change(*last_, sample, k) - usual_change_[k]);
      }
    }
  }
  buffer.add(sample);
  last_ = sample;
}

void InputChecks::add(const InputSample& sample, InputBuffer& buffer) {
  Six value;
  value << sample.angular, sample.linear;
  const bool first = !last_ && !held_ && varied_ == 0;
  require_next(sample, first ? std::nullopt : std::optional(newest_ns_));
  newest_ns_ = sample.t_ns;
  for (std::size_t k = 0; k < 2; ++k) {
    if (part(sample, k).cwiseAbs().maxCoeff() > limits_.impossible[k]) {
      ++counts_[InputFault::kImpossible];
      ++varied_;
      return;
    }
  }
  const bool stuck = is_stuck(value);
  value_ = value;
  if (stuck) {
    ++counts_[InputFault::kStuck];
    return;
  }
  if (held_) {
    InputSample held = *std::exchange(held_, std::nullopt);
    const bool back =
        change(*last_, sample, 0) <= kBack * change(*last_, held, 0) + limits_.jump[0] * kBack &&
        change(*last_, sample, 1) <= kBack * change(*last_, held, 1) + limits_.jump[1] * kBack;
    if (back) {
      ++counts_[InputFault::kSpike];
      accept(sample, buffer);
      return;
    }
    accept(held, buffer);  // it stays there: a jolt
    accept(sample, buffer);
    return;
  }
  if (last_ && (jumps(*last_, sample, 0, limits_.jump[0]) || jumps(*last_, sample, 1, limits_.jump[1]))) {
    held_ = sample;
    return;
  }
  accept(sample, buffer);
}

}  // namespace limber
