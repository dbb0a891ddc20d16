// SPDX-License-Identifier: MIT
#include "fault_fields.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <string_view>

#include "hold_alternative.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/split.hpp"
#include "limber/simulate/decalibration.hpp"
#include "limber/simulate/scenario_presets.hpp"

namespace limber {
namespace {

using detail::FieldVisitor;
using detail::kAnyNumber;
using detail::kSeconds;
using detail::Range;
using detail::Unit;

constexpr double kStandardGravity = 9.80665;  // [m/s^2]

const Unit kGravities{"g", kStandardGravity};
const Range kTime{.min = 0.0, .max = 1e6};
const Range kDuration{.min = 0.0, .max = 1e6, .min_excluded = true};
const Range kSize{.min = 0.0, .max = 1e6, .min_excluded = true};

/// A number without a default.
void required(FieldVisitor& io, const std::string& key, double& value, const Range& range, const Unit& unit) {
  io.require(key);
  io.number(key, value, range, unit);
}

void visit_time(FieldVisitor& io, double& at) { required(io, "at", at, kTime, kSeconds); }

void visit_span(FieldVisitor& io, double& at, double& duration) {
  visit_time(io, at);
  required(io, "duration", duration, kDuration, kSeconds);
}

void visit_fields(FieldVisitor& io, GyroBiasStep& f) {
  visit_time(io, f.at);
  required(io, "size", f.size, kSize, {"rad/s"});
}

void visit_fields(FieldVisitor& io, AccelBiasStep& f) {
  visit_time(io, f.at);
  required(io, "size", f.size, kSize, {"m/s^2"});
}

void visit_fields(FieldVisitor& io, ImuSpike& f) {
  visit_time(io, f.at);
  required(io, "size", f.size, kSize, kGravities);
}

void visit_fields(FieldVisitor& io, ImuSaturation& f) {
  required(io, "accel", f.accel, kSize, kGravities);
  required(io, "gyro", f.gyro, kSize, {"deg/s", detail::kDegree});
}

void visit_fields(FieldVisitor& io, ImuStuck& f) { visit_span(io, f.at, f.duration); }
void visit_fields(FieldVisitor& io, ImuGap& f) { visit_span(io, f.at, f.duration); }

void visit_fields(FieldVisitor& io, ClockStep& f) {
  visit_time(io, f.at);
  required(io, "size", f.size, kAnyNumber, kSeconds);
}

void visit_fields(FieldVisitor& io, RightLate& f) {
  visit_span(io, f.at, f.duration);
  required(io, "delay", f.delay, kDuration, kSeconds);
}

void visit_fields(FieldVisitor& io, FramesRepeated& f) { visit_span(io, f.at, f.duration); }
void visit_fields(FieldVisitor& io, FrameGap& f) { visit_span(io, f.at, f.duration); }

/// Names and values of a fault in short, in the order of visit_fields.
struct Words {
  std::string_view kind;
  std::vector<std::string_view> keys;
};

/// In the order of Fault's alternatives.
const std::vector<Words>& kinds() {
  static const std::vector<Words> all = {
      {"gyro_bias_step", {"at", "size"}},      {"accel_bias_step", {"at", "size"}},
      {"imu_spike", {"at", "size"}},           {"imu_saturation", {"accel", "gyro"}},
      {"imu_stuck", {"at", "duration"}},       {"imu_gap", {"at", "duration"}},
      {"clock_step", {"at", "size"}},          {"right_late", {"at", "duration", "delay"}},
      {"frames_repeated", {"at", "duration"}}, {"frame_gap", {"at", "duration"}},
  };
  return all;
}

std::string with_hyphens(std::string_view kind) {
  std::string text(kind);
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

[[noreturn]] void refuse(const std::string& text) {
  std::vector<std::string> forms;
  for (const Words& words : kinds()) {
    forms.push_back(fmt::format("{}={}", with_hyphens(words.kind), fmt::join(words.keys, ":")));
  }
  throw std::invalid_argument(fmt::format("fault '{}': expected one of {} (s, g, deg/s, rad/s, m/s^2)", text,
                                          fmt::join(forms, ", ")));
}

}  // namespace

void detail::visit_fault(FieldVisitor& io, Fault& fault) {
  std::vector<std::string> names;
  for (const Words& words : kinds()) {
    names.emplace_back(words.kind);
  }
  io.require("kind");
  hold_alternative(fault, io.choice("kind", fault.index(), names));
  std::visit([&io](auto& kind) { visit_fields(io, kind); }, fault);
}

Fault fault_from_string(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string kind = text.substr(0, equals);
  const auto words = std::find_if(kinds().begin(), kinds().end(),
                                  [&](const Words& w) { return with_hyphens(w.kind) == kind; });
  if (words == kinds().end() || equals == std::string::npos) {
    refuse(text);
  }
  const std::vector<std::string_view> values = split(std::string_view(text).substr(equals + 1), ':');
  if (values.size() != words->keys.size()) {
    refuse(text);
  }
  std::string yaml = fmt::format("kind: {}\n", words->kind);
  for (std::size_t i = 0; i < values.size(); ++i) {
    yaml += fmt::format("{}: \"{}\"\n", words->keys[i], values[i]);
  }
  Fault fault;
  try {
    detail::read_fields(yaml, text, [&](FieldVisitor& io) { detail::visit_fault(io, fault); });
  } catch (const DataError& error) {
    throw std::invalid_argument(fmt::format("fault '{}': {}", text, error.without_place()));
  }
  return fault;
}

}  // namespace limber
