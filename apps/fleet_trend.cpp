// SPDX-License-Identifier: MIT
#include "fleet_trend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "limber/evaluate/statistics.hpp"
#include "text_table.hpp"

namespace limber::app {
namespace {

constexpr std::size_t kFewest = 3;
constexpr double kHour = 3600.0, kDay = 86'400.0;  // [s]
constexpr double kNormal = 1.959964;               // two-sided 95 %

const HealthState& state_of_row(const FleetRow& row) { return *row.diagnosis->state; }

/// Seconds since the first of them, where all are dated.
std::optional<std::vector<double>> seconds_of(const std::vector<FleetRow>& rows,
                                              const std::vector<std::size_t>& of) {
  std::vector<double> out;
  const std::int64_t first = state_of_row(rows[of.front()]).rig.from_ns;
  for (const std::size_t k : of) {
    const RigRecord& rig = state_of_row(rows[k]).rig;
    if (!is_dated(rig.from_ns)) {
      return std::nullopt;
    }
    out.push_back(1e-9 * (static_cast<double>(rig.from_ns - first) +
                          0.5 * static_cast<double>(rig.to_ns - rig.from_ns)));
  }
  const auto [least, most] = std::minmax_element(out.begin(), out.end());
  return *most > *least ? std::optional(out) : std::nullopt;
}

/// The places of the recordings on the axis of time, in the unit that `per` gets.
std::vector<double> times_of(const std::vector<FleetRow>& rows, const std::vector<std::size_t>& of,
                             std::string& per) {
  std::vector<double> out;
  if (auto seconds = seconds_of(rows, of)) {
    const auto [least, most] = std::minmax_element(seconds->begin(), seconds->end());
    const double unit = *most - *least < 0.5 * kDay ? kHour : kDay;
    per = unit == kDay ? "day" : "hour";
    for (const double t : *seconds) {
      out.push_back(t / unit);
    }
    return out;
  }
  per = "recording";
  for (std::size_t k = 0; k < of.size(); ++k) {
    out.push_back(static_cast<double>(k));
  }
  return out;
}

struct Sight {
  double t, value, sigma;
};

std::optional<AxisTrend> slope_of(const std::vector<Sight>& sights) {
  double w = 0.0, wt = 0.0, wy = 0.0;
  for (const Sight& s : sights) {
    const double weight = 1.0 / (s.sigma * s.sigma);
    if (!std::isfinite(weight) || !std::isfinite(s.value)) {
      return std::nullopt;
    }
    w += weight;
    wt += weight * s.t;
    wy += weight * s.value;
  }
  double wtt = 0.0, wty = 0.0, squares = 0.0;
  for (const Sight& s : sights) {
    const double weight = 1.0 / (s.sigma * s.sigma), dt = s.t - wt / w;
    wtt += weight * dt * dt;
    wty += weight * dt * (s.value - wy / w);
  }
  AxisTrend out;
  out.slope = wty / wtt;
  for (const Sight& s : sights) {
    const double off = (s.value - wy / w - out.slope * (s.t - wt / w)) / s.sigma;
    squares += off * off;
  }
  const double dof = static_cast<double>(sights.size()) - 2.0;
  out.half_width = std::max(kNormal, student_quantile(dof) * std::sqrt(squares / dof)) / std::sqrt(wtt);
  return std::isfinite(out.slope) && std::isfinite(out.half_width) ? std::optional(out) : std::nullopt;
}

FleetTrend trend_of(const std::vector<FleetRow>& rows, std::vector<std::size_t> of) {
  FleetTrend out;
  out.rows = std::move(of);
  const std::vector<double> times = times_of(rows, out.rows, out.per);
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    std::vector<Sight> sights;
    for (std::size_t k = 0; k < out.rows.size(); ++k) {
      const RigRecord& rig = state_of_row(rows[out.rows[k]]).rig;
      const RigEstimate estimate = rig.estimate.rig(rig.theta);
      sights.push_back({times[k], rig.theta(axis) + estimate.delta(axis), estimate.sigma()(axis)});
    }
    out.axes[static_cast<std::size_t>(axis)] = slope_of(sights);
  }
  return out;
}

/// In degrees or millimetres.
double shown(double value, std::size_t axis) {
  return in_degrees_and_mm(RigParameters::Constant(value))(static_cast<Eigen::Index>(axis));
}

}  // namespace

bool is_dated(std::int64_t t_ns) {
  constexpr std::int64_t kYear2000 = 946'684'800'000'000'000;
  return t_ns >= kYear2000;
}

std::vector<FleetTrend> fleet_trends(const std::vector<FleetRow>& rows) {
  std::vector<std::vector<std::size_t>> rigs;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (!rows[k].diagnosis || !rows[k].diagnosis->state) {
      continue;
    }
    const auto same = std::find_if(rigs.begin(), rigs.end(), [&](const auto& rig) {
      return state_of_row(rows[rig.front()]).cameras == state_of_row(rows[k]).cameras;
    });
    (same != rigs.end() ? *same : rigs.emplace_back()).push_back(k);
  }
  std::vector<FleetTrend> out;
  for (const auto& rig : rigs) {
    if (rig.size() >= kFewest) {
      out.push_back(trend_of(rows, rig));
    }
  }
  return out;
}

std::string to_text(const FleetTrend& trend, const std::vector<FleetRow>& rows) {
  std::vector<TextRow> table = {{"axis", "a " + trend.per, "from", "to 95 %", ""}};
  for (std::size_t k = 0; k < 6; ++k) {
    const std::string name = fmt::format("{} [{}]", kParameterNames[k], k < 3 ? "deg" : "mm");
    if (!trend.axes[k]) {
      table.push_back({name, "-", "-", "-", "not known in every recording"});
      continue;
    }
    const AxisTrend& axis = *trend.axes[k];
    table.push_back({name, fmt::format("{:+.3g}", shown(axis.slope, k)),
                     fmt::format("{:+.3g}", shown(axis.slope - axis.half_width, k)),
                     fmt::format("{:+.3g}", shown(axis.slope + axis.half_width, k)),
                     axis.is_certain() ? "drifts" : ""});
  }
  return fmt::format("Trend of the {} recordings with the cameras of {}\n{}", trend.rows.size(),
                     rows[trend.rows.front()].dataset, text_table(table));
}

Json to_json(const FleetTrend& trend) {
  Json axes = Json::object();
  for (std::size_t k = 0; k < 6; ++k) {
    const auto& axis = trend.axes[k];
    axes[std::string(kParameterNames[k])] = axis ? Json{{"slope", shown(axis->slope, k)},
                                                        {"half_width_95", shown(axis->half_width, k)},
                                                        {"unit", k < 3 ? "deg" : "mm"},
                                                        {"drifts", axis->is_certain()}}
                                                 : Json(nullptr);
  }
  return {{"recordings", trend.rows.size()}, {"per", trend.per}, {"axes", axes}};
}

}  // namespace limber::app
