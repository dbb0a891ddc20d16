// SPDX-License-Identifier: MIT
#include "faults.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "limber/core/random.hpp"

namespace limber::detail {
namespace {

using Eigen::Vector3d;

std::int64_t nanoseconds(double time) { return std::llround(time * 1e9); }

/// Times t in [at, at + duration).
struct Span {
  std::int64_t begin_ns, end_ns;

  template <typename F>
  explicit Span(const F& fault)
      : begin_ns(nanoseconds(fault.at)), end_ns(nanoseconds(fault.at + fault.duration)) {}

  [[nodiscard]] bool holds(std::int64_t t_ns) const { return t_ns >= begin_ns && t_ns < end_ns; }
};

/// The last one before `t_ns`; the end of `list` if there is none.
template <typename T>
typename std::vector<T>::const_iterator last_before(const std::vector<T>& list, std::int64_t t_ns) {
  const auto first = std::lower_bound(list.begin(), list.end(), t_ns,
                                      [](const T& entry, std::int64_t t) { return entry.t_ns < t; });
  return first == list.begin() ? list.end() : first - 1;
}

template <typename T>
void erase(const Span& span, std::vector<T>& list) {
  std::erase_if(list, [&](const T& entry) { return span.holds(entry.t_ns); });
}

struct SpoilImu {
  std::vector<ImuSample>& samples;
  Vector3d direction;

  void operator()(const ImuSpike& f) const {
    const auto hit = std::find_if(samples.begin(), samples.end(),
                                  [&](const ImuSample& sample) { return sample.t_ns >= nanoseconds(f.at); });
    if (hit != samples.end()) {
      hit->accel_imu += f.size * direction;
    }
  }
  void operator()(const ImuSaturation& f) const {
    for (ImuSample& sample : samples) {
      sample.accel_imu = sample.accel_imu.cwiseMax(-f.accel).cwiseMin(f.accel);
      sample.omega_imu = sample.omega_imu.cwiseMax(-f.gyro).cwiseMin(f.gyro);
    }
  }
  void operator()(const ImuStuck& f) const {
    const Span span(f);
    const auto last = last_before(samples, span.begin_ns);
    if (last == samples.end()) {
      return;
    }
    const ImuSample value = *last;
    for (ImuSample& sample : samples) {
      if (span.holds(sample.t_ns)) {
        sample = {sample.t_ns, value.omega_imu, value.accel_imu};
      }
    }
  }
  void operator()(const ImuGap& f) const { erase(Span(f), samples); }
  void operator()(const ClockStep& f) const {
    const std::int64_t begin_ns = nanoseconds(f.at);
    std::int64_t latest_ns = -1;
    std::erase_if(samples, [&](ImuSample& sample) {
      sample.t_ns += sample.t_ns >= begin_ns ? nanoseconds(f.size) : 0;
      const bool lost = sample.t_ns <= latest_ns;
      latest_ns = std::max(latest_ns, sample.t_ns);
      return lost;
    });
  }
  void operator()(const auto&) const {}
};

struct SpoilFrames {
  std::vector<StereoFrame>& frames;

  void operator()(const FramesRepeated& f) const {
    const Span span(f);
    const auto last = last_before(frames, span.begin_ns);
    if (last == frames.end()) {
      return;
    }
    const std::vector<StereoObservation> pixels = last->observations;
    for (StereoFrame& frame : frames) {
      if (span.holds(frame.t_ns)) {
        frame.observations = pixels;
      }
    }
  }
  void operator()(const FrameGap& f) const { erase(Span(f), frames); }
  void operator()(const auto&) const {}
};

/// Calls visit(fault, i) for all faults in the order in which they act, i the place in the list.
template <typename Visit>
void in_order(const std::vector<Fault>& faults, const Visit& visit) {
  for (std::size_t kind = 0; kind < std::variant_size_v<Fault>; ++kind) {
    for (std::size_t i = 0; i < faults.size(); ++i) {
      if (faults[i].index() == kind) {
        visit(faults[i], i);
      }
    }
  }
}

Vector3d random_direction(std::uint64_t seed, std::uint64_t run, std::size_t i) {
  return RandomStream(seed, run, "fault_direction").normal3(i).normalized();
}

}  // namespace

void step_biases(const std::vector<Fault>& faults, std::uint64_t seed, std::uint64_t run,
                 std::vector<GroundTruthState>& truth) {
  in_order(faults, [&](const Fault& fault, std::size_t i) {
    const Vector3d direction = random_direction(seed, run, i);
    for (GroundTruthState& state : truth) {
      if (const auto* f = std::get_if<GyroBiasStep>(&fault); f && state.t_ns >= nanoseconds(f->at)) {
        state.bias_gyro += f->size * direction;
      }
      if (const auto* f = std::get_if<AccelBiasStep>(&fault); f && state.t_ns >= nanoseconds(f->at)) {
        state.bias_accel += f->size * direction;
      }
    }
  });
}

void spoil_imu(const std::vector<Fault>& faults, std::uint64_t seed, std::uint64_t run,
               std::vector<ImuSample>& samples) {
  in_order(faults, [&](const Fault& fault, std::size_t i) {
    std::visit(SpoilImu{samples, random_direction(seed, run, i)}, fault);
  });
}

std::int64_t right_delay(const std::vector<Fault>& faults, std::int64_t t_ns) {
  std::int64_t delay_ns = 0;
  for (const Fault& fault : faults) {
    if (const auto* f = std::get_if<RightLate>(&fault); f && Span(*f).holds(t_ns)) {
      delay_ns = std::min(nanoseconds(f->delay), t_ns);
    }
  }
  return delay_ns;
}

void spoil_frames(const std::vector<Fault>& faults, std::vector<StereoFrame>& frames) {
  in_order(faults, [&](const Fault& fault, std::size_t) { std::visit(SpoilFrames{frames}, fault); });
}

}  // namespace limber::detail
