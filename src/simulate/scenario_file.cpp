// SPDX-License-Identifier: MIT
#include "limber/simulate/scenario_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "decalibration_fields.hpp"
#include "fault_fields.hpp"
#include "field_visitor.hpp"
#include "hold_alternative.hpp"
#include "io/text_file.hpp"
#include "limber/simulate/scenario_presets.hpp"
#include "rig_fields.hpp"

namespace limber {
namespace {

using detail::FieldVisitor;
using detail::hold_alternative;
using detail::kAnyNumber;
using detail::kDegree;
using detail::kDegrees;
using detail::kMetres;
using detail::kNotNegative;
using detail::kNoUnit;
using detail::kPositive;
using detail::kSeconds;
using detail::Range;
using detail::Unit;

constexpr double kMaxSamples = 1e7;  // of one sensor in one recording

const Range kProbability{.min = 0.0, .max = 1.0};
const Range kRate{.min = 0.1, .max = 10000.0};  // Hz

const Unit kMetresPerSecond{"m/s", 1.0};
const Unit kHertz{"Hz", 1.0};
const Unit kPixels{"px", 1.0};

void check_order(FieldVisitor& io, const std::string& larger_key, double smaller, double larger,
                 const std::string& smaller_key) {
  io.check(larger_key, larger >= smaller, "not below " + smaller_key,
           fmt::format("{:.6g} < {:.6g}", larger, smaller));
}

/// A mapping that switches something on by being there.
template <typename T>
void visit_optional(FieldVisitor& io, const std::string& key, std::optional<T>& value,
                    void (*visit)(FieldVisitor&, T&)) {
  if (io.has(key, value.has_value())) {
    T present = value.value_or(T{});
    io.mapping(key, [&](FieldVisitor& child) { visit(child, present); });
    value = present;
  }
}

// ---- trajectory

void visit_fields(FieldVisitor& io, RandomSplineTrajectory& t) {
  io.numbers("half_extent", t.half_extent, kNotNegative, kMetres);
  io.numbers("max_angles", t.max_angles, {.min = 0.0, .max = 180.0}, {"deg: roll, pitch, yaw", kDegree});
  io.number("knot_spacing", t.knot_spacing, {.min = 0.01, .max = 1e6}, kSeconds);
  io.number("max_speed", t.max_speed, kNotNegative, kMetresPerSecond);
  io.number("max_angular_rate", t.max_angular_rate, kNotNegative, {"rad/s"});
  io.number("rest", t.rest, kNotNegative, kSeconds);
}

void visit_fields(FieldVisitor& io, FigureEightTrajectory& t) {
  io.number("half_length", t.half_length, kPositive, kMetres);
  io.number("height", t.height, kNotNegative, kMetres);
  io.number("min_speed", t.min_speed, kPositive, kMetresPerSecond);
  io.number("max_speed", t.max_speed, kPositive, kMetresPerSecond);
  check_order(io, "max_speed", t.min_speed, t.max_speed, "min_speed");
  io.number("tilt", t.tilt, {.min = 0.0, .max = 80.0}, kDegrees);
  io.number("rest", t.rest, kNotNegative, kSeconds);
}

void visit_fields(FieldVisitor& io, FileTrajectory& t) {
  io.require("path");
  io.path("path", t.path);
  io.check("path", !t.path.empty(), "as the name of a TUM file", "nothing");
  io.number("start", t.start, kNotNegative, kSeconds);
  io.number("knot_spacing", t.knot_spacing, {.min = 0.01, .max = 1e6}, kSeconds);
}

void visit_fields(FieldVisitor& io, TrajectoryScenario& trajectory) {
  hold_alternative(trajectory,
                   io.choice("kind", trajectory.index(), {"random_spline", "figure_eight", "file"}));
  std::visit([&io](auto& kind) { visit_fields(io, kind); }, trajectory);
}

// ---- world and rig

void visit_fields(FieldVisitor& io, MovingBodyScenario& m) {
  io.number("share", m.share, kProbability, kNoUnit);
  io.number("speed", m.speed, kNotNegative, kMetresPerSecond);
  io.number("radius", m.radius, kPositive, kMetres);
  io.number("start", m.start, kNotNegative, kSeconds);
}

void visit_fields(FieldVisitor& io, WorldScenario& w) {
  io.integer("points", w.points, {.min = 0.0, .max = 1e6}, kNoUnit);
  w.placement = static_cast<PointPlacement>(
      io.choice("placement", static_cast<std::size_t>(w.placement), {"around", "in_view"}));
  io.number("min_distance", w.min_distance, kNotNegative, kMetres);
  io.number("max_distance", w.max_distance, kPositive, kMetres);
  check_order(io, "max_distance", w.min_distance, w.max_distance, "min_distance");
  io.number("max_elevation", w.max_elevation, {.min = 0.0, .max = 90.0}, kDegrees);
  io.number("min_range", w.min_range, kPositive, kMetres);
  io.number("max_range", w.max_range, kPositive, kMetres);
  check_order(io, "max_range", w.min_range, w.max_range, "min_range");
  io.boolean("left_only", w.left_only);
  visit_optional(io, "moving_body", w.moving_body, visit_fields);
}

// ---- noise and faults

void visit_fields(FieldVisitor& io, NoiseScenario& n) {
  io.number("pixel", n.pixel, {.min = 0.0, .max = 1000.0}, kPixels);
  io.number("accel", n.accel, kNotNegative, {"m/s^2 per sample"});
  io.number("gyro", n.gyro, kNotNegative, {"deg/s per sample", kDegree});
  io.number("accel_walk", n.accel_walk, kNotNegative, {"m/s^3/sqrt(Hz)"});
  io.number("gyro_walk", n.gyro_walk, kNotNegative, {"rad/s^2/sqrt(Hz)"});
  if (io.has("stated", !n.stated)) {
    io.boolean("stated", n.stated);
  }
}

void visit_fields(FieldVisitor& io, PixelScenario& p) {
  const Range sigma{.min = 0.0, .max = 1000.0};
  io.number("per_track", p.per_track, sigma, kPixels);
  io.number("correlated", p.correlated, sigma, kPixels);
  io.number("correlated_coefficient", p.correlated_coefficient, {.min = 0.0, .max = 0.9999}, kNoUnit);
  io.number("field", p.field, sigma, {"px rms"});
  io.number("mismatches", p.mismatches, kProbability, kNoUnit);
}

/// A word for all of them, which the noise's own keys may still change, or each on its own.
void visit_pixels(FieldVisitor& io, Scenario& s) {
  if (io.is_word("pixels")) {
    const auto preset = io.choice("pixels", 0, {"white", "realistic"});
    set_pixels(s, static_cast<PixelPreset>(preset));
  } else if (io.has("pixels", !are_white(s.pixels))) {
    io.mapping("pixels", [&](FieldVisitor& child) { visit_fields(child, s.pixels); });
  }
}

void visit_faults(FieldVisitor& io, std::vector<Fault>& faults) {
  if (io.has("faults", !faults.empty())) {
    io.list(
        "faults", faults.size(), [&](std::size_t size) { faults.assign(size, {}); },
        [&](std::size_t i, FieldVisitor& entry) { detail::visit_fault(entry, faults[i]); });
  }
}

void visit_fields(FieldVisitor& io, OdometryScenario& o) {
  io.number("rate", o.rate, kRate, kHertz);
  io.number("velocity", o.velocity, kNotNegative, {"m/s per sample"});
  io.number("angular_rate", o.angular_rate, kNotNegative, {"rad/s per sample"});
}

void visit_fields(FieldVisitor& io, InitialSigma& s) {
  io.number("position", s.position, kNotNegative, kMetres);
  io.number("attitude", s.attitude, kNotNegative, {"rad"});
  io.number("velocity", s.velocity, kNotNegative, kMetresPerSecond);
  io.number("bias_accel", s.bias_accel, kNotNegative, {"m/s^2"});
  io.number("bias_gyro", s.bias_gyro, kNotNegative, {"rad/s"});
}

void visit_fields(FieldVisitor& io, DropoutScenario& d) {
  io.number("right_detections", d.right_detections, kProbability, kNoUnit);
  io.number("frames", d.frames, kProbability, kNoUnit);
  io.number("imu_samples", d.imu_samples, kProbability, kNoUnit);
}

// ---- what estimators assume

void visit_fields(FieldVisitor& io, FilterScenario& f, double baseline) {
  constexpr double kStepsPerSecond = 100.0;  // of the paper
  constexpr double kSquareMillimetre = 1e-6;
  io.mapping("initial", [&](FieldVisitor& child) { visit_fields(child, f.initial); });
  io.rig_parameters("theta_sigma", f.theta_sigma, baseline, kNotNegative);
  io.numbers("theta_walk_rotation", f.theta_walk.head<3>(), kNotNegative,
             {"rad^2 per 10 ms", kStepsPerSecond});
  io.numbers("theta_walk_translation", f.theta_walk.tail<3>(), kNotNegative,
             {"mm^2 per 10 ms", kSquareMillimetre * kStepsPerSecond});
  io.number("acceleration_noise", f.acceleration_noise, kNotNegative, {"m/s^2/sqrt(Hz)"});
  io.number("angular_noise", f.angular_noise, kNotNegative, {"rad/s^2/sqrt(Hz)"});
  io.boolean("gate", f.gate);
  io.integer("max_landmarks", f.max_landmarks, {.min = 1.0, .max = 1e5}, kNoUnit);
}

void check_sample_counts(FieldVisitor& io, const Scenario& s) {
  const double fastest = std::max({s.imu_rate, s.stereo_rate, s.odometry ? s.odometry->rate : 0.0});
  io.check("duration", s.duration * fastest <= kMaxSamples,
           fmt::format("with at most {:.0e} samples of each sensor", kMaxSamples),
           fmt::format("{:.6g} s at {:.6g} Hz", s.duration, fastest));
}

void visit_fields(FieldVisitor& io, Scenario& s) {
  io.text("name", s.name);
  io.number("duration", s.duration, {.min = 0.0, .max = 1e4, .min_excluded = true}, kSeconds);
  io.mapping("rates", [&](FieldVisitor& child) {
    child.number("imu", s.imu_rate, kRate, kHertz);
    child.number("stereo", s.stereo_rate, kRate, kHertz);
  });
  io.boolean("use_imu", s.use_imu);
  io.boolean("same_world_in_all_runs", s.same_world_in_all_runs);
  io.number("gravity", s.gravity, kNotNegative, {"m/s^2"});
  io.mapping("trajectory", [&](FieldVisitor& child) { visit_fields(child, s.trajectory); });
  io.mapping("world", [&](FieldVisitor& child) { visit_fields(child, s.world); });
  io.mapping("rig", [&](FieldVisitor& child) { detail::visit_rig(child, s.rig); });
  visit_pixels(io, s);
  io.mapping("noise", [&](FieldVisitor& child) { visit_fields(child, s.noise); });
  visit_optional(io, "odometry", s.odometry, visit_fields);
  check_sample_counts(io, s);
  io.mapping("initial", [&](FieldVisitor& child) { visit_fields(child, s.initial); });
  io.mapping("dropout", [&](FieldVisitor& child) { visit_fields(child, s.dropout); });
  visit_faults(io, s.faults);
  const double baseline = s.rig.theta.tail<3>().norm();
  io.list(
      "decalibration", s.decalibration.size(), [&](std::size_t size) { s.decalibration.assign(size, {}); },
      [&](std::size_t i, FieldVisitor& entry) { detail::visit_signal(entry, s.decalibration[i], baseline); });
}

/// Relative paths start at the folder of the scenario file.
void resolve_path(Scenario& scenario, const std::filesystem::path& file) {
  if (auto* trajectory = std::get_if<FileTrajectory>(&scenario.trajectory)) {
    trajectory->path = (std::filesystem::absolute(file).parent_path() / trajectory->path).lexically_normal();
  }
}

}  // namespace

Scenario parse_scenario(std::string_view text, const std::filesystem::path& file) {
  Scenario scenario;
  scenario.name = file.stem().string();
  detail::read_fields(std::string(text), file.string(), [&](FieldVisitor& io) {
    visit_fields(io, scenario);
    const double baseline = scenario.rig.theta.tail<3>().norm();
    scenario.filter.gate = has_wrong_points(scenario);
    scenario.filter.initial = scenario.initial;
    scenario.filter.theta_sigma = plausible_error(baseline);
    io.mapping("filter", [&](FieldVisitor& child) { visit_fields(child, scenario.filter, baseline); });
  });
  resolve_path(scenario, file);
  return scenario;
}

Scenario read_scenario(const std::filesystem::path& path) {
  return parse_scenario(detail::load_text(path), path);
}

std::string format_scenario(const Scenario& scenario) {
  Scenario copy = scenario;
  return detail::write_fields([&](FieldVisitor& io) {
    visit_fields(io, copy);
    io.mapping("filter", [&](FieldVisitor& child) {
      visit_fields(child, copy.filter, copy.rig.theta.tail<3>().norm());
    });
  });
}

void check_scenario(const Scenario& scenario) { static_cast<void>(format_scenario(scenario)); }

}  // namespace limber
