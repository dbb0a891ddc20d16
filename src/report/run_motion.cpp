// SPDX-License-Identifier: MIT
// Velocity and biases with three standard deviations.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "run_sections.hpp"

namespace limber::detail {
namespace {

using Vectors = std::optional<Eigen::Vector3d> TrajectoryRow::*;

/// What one figure shows of each state.
struct Quantity {
  const char *id, *title, *unit;
  Vectors value, sigma;
  Eigen::Vector3d GroundTruthState::*truth;
};

constexpr Quantity kVelocity{"velocity",
                             "Velocity",
                             "m/s",
                             &TrajectoryRow::v_world_body,
                             &TrajectoryRow::sigma_v,
                             &GroundTruthState::v_world_body};
constexpr std::array<Quantity, 2> kBiases = {
    Quantity{"bias-gyro", "Bias of the gyroscope", "rad/s", &TrajectoryRow::bias_gyro,
             &TrajectoryRow::sigma_bias_gyro, &GroundTruthState::bias_gyro},
    Quantity{"bias-accel", "Bias of the accelerometer", "m/s²", &TrajectoryRow::bias_accel,
             &TrajectoryRow::sigma_bias_accel, &GroundTruthState::bias_accel}};

/// One axis of a quantity in one panel, with its bounds.
struct Curves {
  ReportTrace value, upper, lower;

  Curves(const DrawnRun& run, std::size_t panel)
      : value{run.name, run.style, TraceShape::kLine, {}, {}, {}, panel},
        upper{"+3 sigma", run.style, TraceShape::kBound, {}, {}, {}, panel},
        lower{"-3 sigma", run.style, TraceShape::kBound, {}, {}, {}, panel} {}

  void add(double t, double y, double around, double sigma) {
    for (const auto& [trace, at] : {std::pair(&value, y), std::pair(&upper, around + 3.0 * sigma),
                                    std::pair(&lower, around - 3.0 * sigma)}) {
      trace->x.push_back(t);
      trace->y.push_back(at);
    }
  }
  /// Bounds that are not known are left out.
  void move_to(ReportFigure& figure) {
    const bool bounded = std::any_of(upper.y.begin(), upper.y.end(), [](double y) { return !std::isnan(y); });
    figure.traces.push_back(std::move(value));
    for (ReportTrace* trace : {&upper, &lower}) {
      if (bounded) {
        figure.traces.push_back(std::move(*trace));
      }
    }
  }
};

bool knows(const DrawnRun& drawn, const Quantity& quantity) {
  return std::any_of(drawn.run->trajectory.begin(), drawn.run->trajectory.end(),
                     [&](const TrajectoryRow& row) { return (row.*quantity.value).has_value(); });
}

double component(const std::optional<Eigen::Vector3d>& vector, std::size_t axis) {
  return vector ? (*vector)(static_cast<Eigen::Index>(axis)) : kNan;
}

/// The estimate with its bounds about it.
void draw_estimate(const DrawnRun& drawn, const Quantity& quantity, std::size_t axis, ReportFigure& figure) {
  Curves curves(drawn, axis);
  for (const TrajectoryRow& row : drawn.run->trajectory) {
    const double y = component(row.*quantity.value, axis);
    curves.add(drawn.seconds(row.t_ns), y, y, component(row.*quantity.sigma, axis));
  }
  curves.move_to(figure);
}

/// Truth minus estimate, with its bounds about zero.
void draw_error(const DrawnRun& drawn, const Quantity& quantity, std::size_t axis, ReportFigure& figure) {
  Curves curves(drawn, axis);
  auto truth = drawn.run->truth_motion.states.begin();
  const auto end = drawn.run->truth_motion.states.end();
  for (const TrajectoryRow& row : drawn.run->trajectory) {
    truth = std::find_if(truth, end, [&](const GroundTruthState& state) { return state.t_ns >= row.t_ns; });
    const bool matches = truth != end && truth->t_ns == row.t_ns;
    const double y = matches ? ((*truth).*quantity.truth)(static_cast<Eigen::Index>(axis)) : kNan;
    curves.add(drawn.seconds(row.t_ns), y - component(row.*quantity.value, axis), 0.0,
               component(row.*quantity.sigma, axis));
  }
  curves.move_to(figure);
}

void draw_truth(const DrawnRun& drawn, const Quantity& quantity, std::size_t axis, ReportFigure& figure) {
  ReportTrace truth{"truth", "truth", TraceShape::kLine, {}, {}, {}, axis};
  for (const GroundTruthState& state : drawn.run->truth_motion.states) {
    truth.x.push_back(drawn.seconds(state.t_ns));
    truth.y.push_back((state.*quantity.truth)(static_cast<Eigen::Index>(axis)));
  }
  figure.traces.push_back(std::move(truth));
}

ReportFigure empty_figure(const Quantity& quantity, const std::string& id, const std::string& title,
                          const std::string& caption) {
  return figure_over_time(quantity.id + id, title,
                          {{"x", quantity.unit}, {"y", quantity.unit}, {"z", quantity.unit}}, caption);
}

void explain_bounds(ReportFigure& figure) {
  const bool bounded = std::any_of(figure.traces.begin(), figure.traces.end(), [](const ReportTrace& trace) {
    return trace.shape == TraceShape::kBound;
  });
  figure.caption += bounded ? " Dotted: three standard deviations of the filter."
                            : " How sure the run is of it, its files do not say.";
}

/// Errors where all runs have a truth; else, of a single run, the velocity itself: worlds of several differ.
std::optional<ReportFigure> velocity_figure(const std::vector<DrawnRun>& runs, const std::string& id) {
  const bool judged = std::all_of(runs.begin(), runs.end(), [](const DrawnRun& drawn) {
    return drawn.run->truth_motion.has_velocity && knows(drawn, kVelocity);
  });
  if (!judged && (runs.size() > 1 || !knows(runs.front(), kVelocity))) {
    return std::nullopt;
  }
  ReportFigure figure =
      judged ? empty_figure(kVelocity, "-error" + id, "Velocity error", "Truth minus estimate, in the world.")
             : empty_figure(kVelocity, id, "Velocity", "In the world; no truth of it is known.");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const DrawnRun& drawn : runs) {
      judged ? draw_error(drawn, kVelocity, axis, figure) : draw_estimate(drawn, kVelocity, axis, figure);
    }
  }
  explain_bounds(figure);
  return figure;
}

std::optional<ReportFigure> bias_figure(const std::vector<DrawnRun>& runs, const Quantity& quantity,
                                        const std::string& id) {
  std::vector<DrawnRun> known;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(known),
               [&](const DrawnRun& drawn) { return knows(drawn, quantity); });
  if (known.empty()) {
    return std::nullopt;
  }
  const bool judged = known.front().run->truth_motion.has_biases;
  ReportFigure figure = empty_figure(quantity, id, quantity.title,
                                     std::string("As estimated, in the body's axes.") +
                                         (judged ? " The truth is what the recording says." : ""));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (judged) {
      draw_truth(known.front(), quantity, axis, figure);
    }
    for (const DrawnRun& drawn : known) {
      draw_estimate(drawn, quantity, axis, figure);
    }
  }
  explain_bounds(figure);
  return figure;
}

}  // namespace

std::vector<ReportFigure> motion_figures(const std::vector<DrawnRun>& runs, const std::string& id) {
  std::vector<ReportFigure> out;
  if (auto velocity = velocity_figure(runs, id)) {
    out.push_back(std::move(*velocity));
  }
  for (const Quantity& quantity : kBiases) {
    if (auto bias = bias_figure(runs, quantity, id)) {
      out.push_back(std::move(*bias));
    }
  }
  return out;
}

ReportSection motion_section(const RunFolder& run) {
  ReportSection section{"motion", "Velocity and biases", {}};
  for (ReportFigure& figure : motion_figures({{&run, run.method, run.method, run.trajectory.front().t_ns}})) {
    section.blocks.emplace_back(std::move(figure));
  }
  return section;
}

}  // namespace limber::detail
