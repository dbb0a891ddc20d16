// SPDX-License-Identifier: MIT
#include "decalibration_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>

#include "hold_alternative.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/split.hpp"
#include "limber/simulate/scenario_file.hpp"
#include "limber/simulate/scenario_presets.hpp"

namespace limber {
namespace {

using detail::FieldVisitor;
using detail::hold_alternative;
using detail::kAnyNumber;
using detail::kNotNegative;
using detail::kNoUnit;
using detail::kPositive;
using detail::kSeconds;

void visit_fields(FieldVisitor&, ConstantShape&) {}

void visit_fields(FieldVisitor& io, SinusShape& s) {
  io.number("angular_frequency", s.angular_frequency, kAnyNumber, {"rad/s"});
  io.number("phase", s.phase, kAnyNumber, {"rad"});
}

void visit_fields(FieldVisitor& io, StepsShape& s) {
  io.list(
      "steps", s.steps.size(), [&](std::size_t size) { s.steps.assign(size, {}); },
      [&](std::size_t i, FieldVisitor& entry) {
        entry.require("at");
        entry.number("at", s.steps[i].at, kAnyNumber, kSeconds);
        entry.require("value");
        entry.number("value", s.steps[i].value, kAnyNumber, kNoUnit);
        entry.check("at", i == 0 || s.steps[i].at > s.steps[i - 1].at, "later than the step before it",
                    fmt::format("{} s", s.steps[i].at));
      });
}

void visit_fields(FieldVisitor& io, SquareWaveShape& s) {
  io.number("period", s.period, {.min = 1e-3, .max = 1e6}, kSeconds);
}

void visit_fields(FieldVisitor& io, RampShape& s) {
  io.number("start", s.start, kNotNegative, kSeconds);
  io.require("end");
  io.number("end", s.end, kPositive, kSeconds);
  io.check("end", s.end > s.start, "later than start", fmt::format("{} s", s.end));
}

void visit_fields(FieldVisitor& io, RandomWalkShape& s) {
  io.number("sigma", s.sigma, kNotNegative, {"1/sqrt(s)"});
}

void visit_fields(FieldVisitor&, WhiteNoiseShape&) {}

/// A vibration is a sinus whose frequency is given in Hz; written, it is a sinus.
void visit_vibration(FieldVisitor& io, SinusShape& s) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  io.require("frequency");
  io.number("frequency", s.angular_frequency, kPositive, {"Hz", kTurn});
  io.number("phase", s.phase, kAnyNumber, {"rad"});
}

}  // namespace

void detail::visit_signal(FieldVisitor& io, DecalibrationSignal& signal, double baseline) {
  constexpr std::size_t kVibration = std::variant_size_v<DecalibrationShape>;
  io.require("shape");
  const std::size_t shape = io.choice(
      "shape", signal.shape.index(),
      {"constant", "sinus", "steps", "square_wave", "ramp", "random_walk", "white_noise", "vibration"});
  io.require("amplitude");
  io.rig_parameters("amplitude", signal.amplitude, baseline, kAnyNumber);
  if (shape == kVibration) {
    visit_vibration(io, signal.shape.emplace<SinusShape>());
    return;
  }
  hold_alternative(signal.shape, shape);
  std::visit([&io](auto& s) { visit_fields(io, s); }, signal.shape);
}

DecalibrationSignal decalibration_from_string(const std::string& text, double baseline) {
  constexpr std::array<std::string_view, 6> kNames = {"ax", "ay", "az", "tx", "ty", "tz"};
  std::array<std::string, 6> amplitude = {"0", "0", "0", "0", "0", "0"};
  std::string keys, shape = "constant";
  for (const std::string_view part : split(text, ',')) {
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos || equals == 0 || equals + 1 == part.size()) {
      throw std::invalid_argument(fmt::format(
          "expected amplitudes and a shape such as ay=0.5,tx=5%,shape=vibration,frequency=1, found '{}'",
          part));
    }
    const std::string_view key = part.substr(0, equals);
    const std::string value(part.substr(equals + 1));
    if (const auto name = std::find(kNames.begin(), kNames.end(), key); name != kNames.end()) {
      amplitude[static_cast<std::size_t>(name - kNames.begin())] = value;
    } else if (key == "shape") {
      shape = value;
    } else {
      keys += fmt::format(", {}: {}", key, value);
    }
  }
  DecalibrationSignal signal;
  const std::string yaml =
      fmt::format("{{shape: {}, amplitude: [{}]{}}}\n", shape, fmt::join(amplitude, ", "), keys);
  try {
    detail::read_fields(yaml, text, [&](FieldVisitor& io) {
      io.call("amplitude", "ax, ay, az (degrees), tx, ty, tz (m, or % of the baseline)");
      detail::visit_signal(io, signal, baseline);
    });
  } catch (const DataError& error) {
    throw std::invalid_argument(fmt::format("{} in '{}'", error.without_place(), text));
  }
  return signal;
}

}  // namespace limber
