// SPDX-License-Identifier: MIT
#include "limber/diagnose/health_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <numbers>

#include "io/json_text.hpp"
#include "limber/core/time.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;

using AxisWords = std::array<std::string_view, 6>;
constexpr AxisWords kSideBySide = {"nod, about x",   "vergence, about y", "roll, about z",
                                   "right, along x", "down, along y",     "forward, along z"};
constexpr AxisWords kOneAbove = {"vergence, about x", "pan, about y",  "roll, about z",
                                 "right, along x",    "down, along y", "forward, along z"};

Json json_of(const SizeInterval& size, const Band& band, HealthVerdict verdict, double unit) {
  return {{"size", unit * size.size}, {"low", unit * size.low},     {"high", unit * size.high},
          {"ok", unit * band.ok},     {"wrong", unit * band.wrong}, {"verdict", to_string(verdict)}};
}

Json sizes_of(const CalibrationState& state, const Tolerance& tolerance) {
  const RigParameters delta = in_degrees_and_mm(state.estimate.delta);
  const RigParameters sigma = in_degrees_and_mm(state.estimate.sigma());
  const RigParameters unit = in_degrees_and_mm(RigParameters::Ones());
  Json axes;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    axes[std::string(kParameterNames[k])] = {{"words", axis_in_words(k, state.vergence)},
                                             {"error", delta(i)},
                                             {"sigma", sigma(i)},
                                             {"ok", unit(i) * state.bands[k].ok},
                                             {"wrong", unit(i) * state.bands[k].wrong},
                                             {"unit", k < 3 ? "deg" : "mm"},
                                             {"verdict", to_string(state.axes[k])}};
  }
  Json depth = json_of(state.effect.depth, tolerance.depth, state.by_depth, 100.0);
  depth["error"] = 100.0 * state.effect.depth_signed;
  depth["baselines"] = tolerance.baselines;
  return {
      {"epipolar_px", json_of(state.effect.epipolar_px, tolerance.epipolar_px, state.by_epipolar, 1.0)},
      {"depth_percent", depth},
      {"most_likely_axis", state.named ? Json(std::string(kParameterNames[*state.named])) : Json(nullptr)},
      {"axes", axes},
      {"windows", state.windows},
      {"tracks", state.tracks},
      {"points", state.points},
      {"points_with_depth", state.deep},
      {"tracks_with_depth", state.deep_tracks}};
}

Json json_of(const std::optional<RigDrift>& drift) {
  if (!drift) {
    return nullptr;
  }
  const double minutes = drift->seconds / 60.0;
  const RigParameters rate = in_degrees_and_mm(drift->change.delta) / minutes;
  const RigParameters sigma = in_degrees_and_mm(drift->change.sigma()) / minutes;
  Json axes;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    axes[std::string(kParameterNames[k])] = {
        {"per_minute", rate(i)}, {"sigma", sigma(i)}, {"unit", k < 3 ? "deg" : "mm"}};
  }
  return {{"most_likely_axis", kParameterNames[drift->named]}, {"axes", axes}};
}

/// "; it drifts: roll, about z by +0.24 ± 0.03 deg a minute"
std::string drift_in_words(const CalibrationState& state) {
  if (!state.drift) {
    return "";
  }
  const auto k = static_cast<Eigen::Index>(state.drift->named);
  const double unit = in_degrees_and_mm(RigParameters::Ones())(k) * 60.0 / state.drift->seconds;
  return fmt::format("; it drifts, mostly in {}: by {:+.3g} ± {:.2g} {} a minute",
                     axis_in_words(state.drift->named, state.vergence), unit * state.drift->change.delta(k),
                     unit * state.drift->change.sigma()(k), k < 3 ? "deg" : "mm");
}

Json json_of(const CalibrationState& state, const HealthSummary& summary, const Tolerance& tolerance) {
  Json out = {{"verdict", to_string(state.verdict)},
              {"from_s", summary.seconds(state.from_ns)},
              {"to_s", summary.seconds(state.to_ns)}};
  out.update(sizes_of(state, tolerance));
  out["drift"] = json_of(state.drift);
  out["movement_px"] = json_of(state.movement.px, tolerance.epipolar_px, state.by_movement, 1.0);
  out["movement_depth_percent"] =
      json_of(state.depth_movement.share, tolerance.depth, state.by_depth_movement, 100.0);
  return out;
}

std::string range(const SizeInterval& size, double unit, const char* name) {
  return fmt::format("{:.2f} {} ({:.2f} to {:.2f})", unit * size.size, name, unit * size.low,
                     unit * size.high);
}

std::string sizes_in_words(const CalibrationState& state, const Tolerance& tolerance) {
  const std::string epipolar = range(state.effect.epipolar_px, 1.0, "px") + " off the epipolar lines";
  if (state.scale_is_lost) {
    return epipolar + ", and nothing tells the depths";
  }
  return fmt::format("{}, {} of the depth at {:g} baselines", epipolar, range(state.effect.depth, 100.0, "%"),
                     tolerance.baselines);
}

std::string movement_in_words(const CalibrationState& state, const Tolerance& tolerance) {
  return fmt::format("{} and {} of the depth at {:g} baselines", range(state.movement.px, 1.0, "px"),
                     range(state.depth_movement.share, 100.0, "%"), tolerance.baselines);
}

/// On average there is nothing wrong.
bool only_moves(const CalibrationState& state) {
  return state.moves() && !is_wrong(state.by_epipolar) && !is_wrong(state.by_depth);
}

std::string why_not(const CalibrationState& state, const Tolerance& tolerance) {
  const bool epipolar = state.by_epipolar == HealthVerdict::kCannotTell,
             depth = state.by_depth == HealthVerdict::kCannotTell;
  if (state.scale_is_lost) {
    return "vision alone has lost the scale of its trajectory";
  }
  if (state.deep == 0) {
    return "the rig hardly moved, so that nothing but stereo tells a depth";
  }
  if (depth && state.tracks >= kFewestTracks && state.deep_tracks < kFewestTracks) {
    return fmt::format("of only {} tracks is the depth known from motion", state.deep_tracks);
  }
  if (epipolar && depth) {
    return "the intervals reach over a limit";
  }
  if (epipolar || depth) {
    return depth ? "the depth is not known well enough" : "the epipolar lines are not known well enough";
  }
  return fmt::format("on average within the tolerance, but it may move from frame to frame by {}",
                     movement_in_words(state, tolerance));
}

}  // namespace

double HealthSummary::seconds(std::int64_t t_ns) const { return seconds_between(begin_ns, t_ns); }

bool HealthSummary::comes_and_goes() const {
  std::size_t returns = 0;
  for (std::size_t k = 0; k < past.size(); ++k) {
    const CalibrationState& next = k + 1 < past.size() ? past[k + 1] : present;
    returns += is_wrong(past[k].verdict) && !is_wrong(next.verdict) ? 1 : 0;
  }
  return returns >= 2 && present.verdict == HealthVerdict::kOk;
}

HealthVerdict HealthSummary::by_states() const {
  return comes_and_goes() ? HealthVerdict::kDegraded : present.verdict;
}

bool HealthSummary::was_wrong() const {
  return std::any_of(past.begin(), past.end(), [](const CalibrationState& s) { return is_wrong(s.verdict); });
}

RigParameters in_degrees_and_mm(const RigParameters& theta) {
  RigParameters out = theta;
  out.head<3>() *= 180.0 / std::numbers::pi;
  out.tail<3>() *= 1e3;
  return out;
}

std::string_view axis_in_words(std::size_t axis, Eigen::Index vergence) {
  return (vergence == 0 ? kOneAbove : kSideBySide).at(axis);
}

std::optional<HealthSummary> summarize_health(std::span<const FrameReport> frames) {
  HealthSummary out;
  const CalibrationReport* last = nullptr;
  for (const FrameReport& frame : frames) {
    const CalibrationReport* report = frame.calibration.get();
    if (report != nullptr && report != last) {
      out.past.insert(out.past.end(), report->past.begin(), report->past.end());
      out.present = report->state;
      last = report;
    }
  }
  if (last == nullptr) {
    return std::nullopt;
  }
  out.begin_ns = frames.front().t_ns;
  out.verdict = out.by_states();
  return out;
}

std::string in_words(const HealthSummary& summary, const Tolerance& tolerance) {
  const CalibrationState& state = summary.present;
  const std::string sizes = sizes_in_words(state, tolerance) + drift_in_words(state);
  if (only_moves(state)) {
    return fmt::format(
        "the cameras move against each other, mostly in {}: {} from frame to frame; on average {}",
        axis_in_words(state.moving_axis(), state.vergence), movement_in_words(state, tolerance), sizes);
  }
  if (summary.comes_and_goes()) {
    return "it is within the tolerance now, but was not all the time: it comes and goes; now " + sizes;
  }
  switch (state.verdict) {
    case HealthVerdict::kOk:
      return (summary.was_wrong() ? fmt::format("within the tolerance since {:.1f} s, but not before: ",
                                                summary.seconds(state.from_ns))
                                  : "within the tolerance: ") +
             sizes;
    case HealthVerdict::kSuspect:
    case HealthVerdict::kDegraded:
      return "beyond what is ok, but of use: " + sizes;
    case HealthVerdict::kDecalibrated:
      return "the calibration is not that of this rig: " + sizes;
    case HealthVerdict::kCannotTell:
      break;
  }
  return why_not(state, tolerance) + ": " + sizes;
}

std::string advice_on(HealthVerdict verdict, bool moves) {
  if (moves) {
    return "find what lets the cameras move against each other (mount, screws, vibration): no calibration "
           "fits them all the time; until then --method lcekf or adaptive";
  }
  switch (verdict) {
    case HealthVerdict::kOk:
      return "nothing; --method ekf gets the most out of a rig that is exact";
    case HealthVerdict::kSuspect:
    case HealthVerdict::kDegraded:
      return "recalibrate when you can; --method lcekf or adaptive do not rely on the calibration";
    case HealthVerdict::kDecalibrated:
      return "recalibrate; until then --method lcekf or adaptive, which do not rely on the calibration";
    case HealthVerdict::kCannotTell:
      break;
  }
  return "record more motion: turn and tilt the rig, with at least twenty points in both cameras that are "
         "matched right, some of them nearer than a hundred baselines";
}

std::string change_in_words(const CalibrationState& change, const Tolerance& tolerance) {
  const std::string sizes = sizes_in_words(change, tolerance);
  switch (change.verdict) {
    case HealthVerdict::kOk:
      return "nothing moved that matters: " + sizes;
    case HealthVerdict::kSuspect:
    case HealthVerdict::kDegraded:
      return "moved, by more than what is ok: " + sizes;
    case HealthVerdict::kDecalibrated:
      return "moved, by more than what is of use: " + sizes;
    case HealthVerdict::kCannotTell:
      break;
  }
  return "cannot tell whether anything moved that matters: " + sizes;
}

std::string change_json(const CalibrationState& change, const Tolerance& tolerance) {
  Json json = {{"verdict", to_string(change.verdict)}};
  json.update(sizes_of(change, tolerance));
  return detail::json_text(json);
}

std::string to_json(const HealthSummary& summary, const WatchOptions& options) {
  Json past = Json::array();
  for (const CalibrationState& state : summary.past) {
    past.push_back(json_of(state, summary, options.tolerance));
  }
  const Json json = {
      {"verdict", to_string(summary.verdict)},
      {"changed_s", summary.past.empty() ? Json(nullptr) : Json(summary.seconds(summary.present.from_ns))},
      {"comes_and_goes", summary.comes_and_goes()},
      {"present", json_of(summary.present, summary, options.tolerance)},
      {"past", past},
      {"window_s", options.window_s},
      {"false_alarms_per_hour", options.false_alarms_per_hour}};
  return detail::json_text(json);
}

}  // namespace limber
