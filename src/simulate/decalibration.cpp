// SPDX-License-Identifier: MIT
#include "limber/simulate/decalibration.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "limber/core/random.hpp"

namespace limber {
namespace {

constexpr std::int64_t kWalkStepNs = 10'000'000;
constexpr double kShortestPeriod = 1e-3;  // [s]
constexpr double kLongest = 1e9;          // [s]: thirty years, and still exact in nanoseconds

std::int64_t nanoseconds(double time) { return std::llround(time * 1e9); }
double seconds(std::int64_t t_ns) { return static_cast<double>(t_ns) / 1e9; }

void require(bool condition, const char* message) {
  if (!condition) {
    throw std::invalid_argument(std::string("Decalibration: ") + message);
  }
}

struct CheckShape {
  void operator()(const ConstantShape&) const {}
  void operator()(const SinusShape& s) const {
    require(std::isfinite(s.angular_frequency) && std::isfinite(s.phase), "a sinus that is not finite");
  }
  void operator()(const StepsShape& s) const {
    for (std::size_t i = 0; i < s.steps.size(); ++i) {
      require(std::abs(s.steps[i].at) <= kLongest && std::isfinite(s.steps[i].value),
              "a step that is not finite");
      require(i == 0 || s.steps[i].at > s.steps[i - 1].at, "steps that are not in increasing time");
    }
  }
  void operator()(const SquareWaveShape& s) const {
    require(s.period >= kShortestPeriod && s.period <= kLongest, "a square wave with a period below 1 ms");
  }
  void operator()(const RampShape& s) const {
    require(std::isfinite(s.start) && std::isfinite(s.end) && s.end > s.start,
            "a ramp that does not end after its start");
  }
  void operator()(const RandomWalkShape& s) const {
    require(std::isfinite(s.sigma) && s.sigma >= 0.0, "a random walk with a negative sigma");
  }
  void operator()(const WhiteNoiseShape&) const {}
};

/// Six independent standard normal draws.
RigParameters normal6(const RandomStream& stream, std::uint64_t i) {
  RigParameters draw;
  draw << stream.normal3(i, 0), stream.normal3(i, 1);
  return draw;
}

std::vector<RigParameters> draw_walk(const RandomWalkShape& shape, double duration,
                                     const RandomStream& stream) {
  const auto steps = static_cast<std::size_t>(nanoseconds(duration) / kWalkStepNs) + 1;
  const double sigma = shape.sigma * std::sqrt(seconds(kWalkStepNs));
  std::vector<RigParameters> walk = {RigParameters::Zero()};
  for (std::size_t k = 0; k < steps; ++k) {
    walk.push_back(walk.back() + sigma * normal6(stream, k));
  }
  return walk;
}

RigParameters interpolate(const std::vector<RigParameters>& walk, std::int64_t t_ns) {
  const auto last = static_cast<std::int64_t>(walk.size()) - 1;
  const std::int64_t i = t_ns / kWalkStepNs;
  if (i >= last) {
    return walk.back();
  }
  const double u = static_cast<double>(t_ns % kWalkStepNs) / static_cast<double>(kWalkStepNs);
  const auto k = static_cast<std::size_t>(i);
  return (1.0 - u) * walk[k] + u * walk[k + 1];
}

/// Value of the shapes that all six parameters share.
struct ScalarValue {
  std::int64_t t_ns;

  double operator()(const ConstantShape&) const { return 1.0; }
  double operator()(const SinusShape& s) const {
    return std::sin(s.angular_frequency * seconds(t_ns) + s.phase);
  }
  double operator()(const StepsShape& s) const {
    double value = 0.0;
    for (const StepsShape::Step& step : s.steps) {
      value = t_ns >= nanoseconds(step.at) ? step.value : value;
    }
    return value;
  }
  double operator()(const SquareWaveShape& s) const {
    const std::int64_t period = nanoseconds(s.period);
    return t_ns % period < period / 2 ? 1.0 : -1.0;
  }
  double operator()(const RampShape& s) const {
    return std::clamp((seconds(t_ns) - s.start) / (s.end - s.start), 0.0, 1.0);
  }
  double operator()(const RandomWalkShape&) const { return 0.0; }
  double operator()(const WhiteNoiseShape&) const { return 0.0; }
};

struct CollectJumps {
  std::int64_t end_ns;
  std::vector<std::int64_t>& jumps;

  void add(std::int64_t t_ns) const {
    if (t_ns > 0 && t_ns <= end_ns) {
      jumps.push_back(t_ns);
    }
  }
  void operator()(const StepsShape& s) const {
    for (const StepsShape::Step& step : s.steps) {
      add(nanoseconds(step.at));
    }
  }
  void operator()(const SquareWaveShape& s) const {
    const std::int64_t period = nanoseconds(s.period);
    for (std::int64_t t = 0; t <= end_ns; t += period) {
      add(t);
      add(t + period / 2);
    }
  }
  void operator()(const auto&) const {}
};

}  // namespace

RigParameters paper_decalibration() {
  RigParameters delta;
  delta << 0.01 * detail::kDegree, -0.05 * detail::kDegree, 0.1 * detail::kDegree, 0.1, -0.01, 0.005;
  return delta;
}

Decalibration::Decalibration(std::vector<DecalibrationSignal> signals, double duration, std::uint64_t seed,
                             std::uint64_t run)
    : seed_(seed), run_(run) {
  require(duration >= 0.0 && duration <= kLongest, "a negative duration");
  for (DecalibrationSignal& signal : signals) {
    require(signal.amplitude.allFinite(), "an amplitude that is not finite");
    std::visit(CheckShape{}, signal.shape);
    Source source{std::move(signal), "decalibration_" + std::to_string(sources_.size()), {}};
    if (const auto* shape = std::get_if<RandomWalkShape>(&source.signal.shape)) {
      source.walk = draw_walk(*shape, duration, RandomStream(seed, run, source.stream));
    }
    sources_.push_back(std::move(source));
  }
}

RigParameters Decalibration::at(std::int64_t t_ns) const {
  require(t_ns >= 0, "a time before the start");
  RigParameters delta = RigParameters::Zero();
  for (const Source& source : sources_) {
    const RigParameters& amplitude = source.signal.amplitude;
    if (std::holds_alternative<RandomWalkShape>(source.signal.shape)) {
      delta += amplitude.cwiseProduct(interpolate(source.walk, t_ns));
    } else if (std::holds_alternative<WhiteNoiseShape>(source.signal.shape)) {
      const RandomStream stream(seed_, run_, source.stream);
      delta += amplitude.cwiseProduct(normal6(stream, static_cast<std::uint64_t>(t_ns)));
    } else {
      delta += std::visit(ScalarValue{t_ns}, source.signal.shape) * amplitude;
    }
  }
  return delta;
}

std::vector<std::int64_t> Decalibration::jumps(std::int64_t end_ns) const {
  std::vector<std::int64_t> jumps;
  for (const Source& source : sources_) {
    std::visit(CollectJumps{end_ns, jumps}, source.signal.shape);
  }
  std::sort(jumps.begin(), jumps.end());
  jumps.erase(std::unique(jumps.begin(), jumps.end()), jumps.end());
  return jumps;
}

}  // namespace limber
