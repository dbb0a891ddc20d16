// SPDX-License-Identifier: MIT
#include "limber/diagnose/health_summary.hpp"

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <numbers>

#include "limber/core/time.hpp"

namespace limber {
namespace {

using Json = nlohmann::ordered_json;
using Axes = std::array<HealthVerdict, 6>;

std::vector<HealthReport> reports_of(std::span<const FrameReport> frames) {
  std::vector<HealthReport> out;
  for (const FrameReport& frame : frames) {
    if (frame.health) {
      out.push_back(*frame.health);
    }
  }
  return out;
}

/// Over the windows that begin at `since_ns` or later; nothing without any.
std::optional<RigOffset> mean_offset(const std::vector<HealthReport>& windows, std::int64_t since_ns) {
  RigParameters weights = RigParameters::Zero();
  RigOffset out;
  for (const HealthReport& window : windows) {
    if (window.gathered_since_ns >= since_ns) {
      const RigParameters weight = window.gathered_sigma.cwiseAbs2().cwiseInverse();
      weights += weight;
      out.delta += weight.cwiseProduct(window.gathered_delta);
      out.sigma += weight.cwiseProduct(window.gathered_sigma);
    }
  }
  if (weights.isZero(0.0)) {
    return std::nullopt;
  }
  return RigOffset{out.delta.cwiseQuotient(weights), out.sigma.cwiseQuotient(weights)};
}

Axes named_axes(const std::vector<HealthReport>& reports, const HealthReport& first_alarm) {
  std::array<std::size_t, 6> named{};
  std::size_t decalibrated = 0;
  for (const HealthReport& report : reports) {
    decalibrated += report.verdict == HealthVerdict::kDecalibrated ? 1 : 0;
    for (std::size_t k = 0; k < 6; ++k) {
      named[k] += report.axes[k] == HealthVerdict::kDecalibrated ? 1 : 0;
    }
  }
  Axes out{};  // kOk
  const bool keeps_to_one = 2 * *std::max_element(named.begin(), named.end()) >= decalibrated;
  for (std::size_t k = 0; k < 6; ++k) {
    if (keeps_to_one ? 2 * named[k] >= decalibrated : first_alarm.axes[k] == HealthVerdict::kDecalibrated) {
      out[k] = HealthVerdict::kDecalibrated;
    }
  }
  return out;
}

/// Axes that no report could judge.
void mark_unseen(const std::vector<HealthReport>& reports, Axes& axes) {
  for (std::size_t k = 0; k < 6; ++k) {
    const bool seen = std::any_of(reports.begin(), reports.end(), [k](const HealthReport& report) {
      return report.axes[k] != HealthVerdict::kCannotTell;
    });
    if (!seen) {
      axes[k] = HealthVerdict::kCannotTell;
    }
  }
}

HealthVerdict verdict_without_alarm(const HealthReport& last, const Axes& axes) {
  if (last.verdict == HealthVerdict::kSuspect) {
    return HealthVerdict::kSuspect;
  }
  const bool blind = std::all_of(axes.begin(), axes.end(),
                                 [](HealthVerdict axis) { return axis == HealthVerdict::kCannotTell; });
  return blind ? HealthVerdict::kCannotTell : HealthVerdict::kOk;
}

/// Bonferroni: the smallest of so many.
double smallest_p_value(const std::vector<HealthReport>& windows) {
  double smallest = 1.0;
  for (const HealthReport& window : windows) {
    smallest = std::min(smallest, window.gathered_p_value);
  }
  return std::min(1.0, smallest * static_cast<double>(windows.size()));
}

std::vector<double> as_list(const RigParameters& theta) {
  const RigParameters shown = in_degrees_and_mm(theta);
  return {shown.data(), shown.data() + shown.size()};
}

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

}  // namespace

RigParameters in_degrees_and_mm(const RigParameters& theta) {
  RigParameters out = theta;
  out.head<3>() *= 180.0 / std::numbers::pi;
  out.tail<3>() *= 1e3;
  return out;
}

std::vector<HealthReport> windows_of(std::span<const HealthReport> reports) {
  std::vector<HealthReport> out;
  for (std::size_t k = 0; k < reports.size(); ++k) {
    if (k + 1 == reports.size() || reports[k + 1].gathered_since_ns != reports[k].gathered_since_ns) {
      out.push_back(reports[k]);
    }
  }
  return out;
}

std::optional<HealthSummary> summarize_health(std::span<const FrameReport> frames) {
  const std::vector<HealthReport> reports = reports_of(frames);
  if (reports.empty()) {
    return std::nullopt;
  }
  const std::int64_t begin_ns = frames.front().t_ns;
  const auto seconds = [begin_ns](std::int64_t t_ns) { return seconds_between(begin_ns, t_ns); };
  const std::vector<HealthReport> windows = windows_of(reports);
  HealthSummary out;
  out.mean = *mean_offset(windows, begin_ns);
  out.since_change = out.mean;
  out.p_value = smallest_p_value(windows);
  const auto alarm =
      std::find_if(reports.begin(), reports.end(), [](const HealthReport& report) { return report.alarm; });
  if (alarm != reports.end()) {
    out.verdict = HealthVerdict::kDecalibrated;
    out.axes = named_axes(reports, *alarm);
    out.first_alarm_s = seconds(alarm->t_ns);
    out.changed_s = seconds(*alarm->changed_ns);
    out.since_change = mean_offset(windows, *alarm->changed_ns)
                           .value_or(RigOffset{alarm->gathered_delta, alarm->gathered_sigma});
    out.p_value = std::min(alarm->p_value, alarm->gathered_p_value);
  }
  mark_unseen(reports, out.axes);
  if (alarm == reports.end()) {
    out.verdict = verdict_without_alarm(reports.back(), out.axes);
  }
  return out;
}

std::string to_json(const HealthSummary& summary, double false_alarms_per_hour) {
  Json axes;
  for (std::size_t k = 0; k < 6; ++k) {
    axes[std::string(kParameterNames[k])] = to_string(summary.axes[k]);
  }
  const Json json = {{"verdict", to_string(summary.verdict)},
                     {"first_alarm_s", or_null(summary.first_alarm_s)},
                     {"changed_s", or_null(summary.changed_s)},
                     {"p_value", summary.p_value},
                     {"axes", axes},
                     {"delta_mean", as_list(summary.mean.delta)},
                     {"delta_sigma", as_list(summary.mean.sigma)},
                     {"delta_since_change", as_list(summary.since_change.delta)},
                     {"sigma_since_change", as_list(summary.since_change.sigma)},
                     {"false_alarms_per_hour", false_alarms_per_hour}};
  return json.dump();
}

}  // namespace limber
