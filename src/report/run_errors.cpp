// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "limber/core/angle.hpp"
#include "run_sections.hpp"

namespace limber::detail {
namespace {

/// Three components over time, each in a panel, with the bounds of three standard deviations. Without truth
/// the bounds alone.
class ErrorFigure {
 public:
  ErrorFigure(ReportFigure figure, const std::string& style) : figure_(std::move(figure)) {
    for (std::size_t k = 0; k < 3; ++k) {
      error_[k] = {"error", style, TraceShape::kLine, {}, {}, {}, k};
      upper_[k] = {"+3 sigma", style, TraceShape::kBound, {}, {}, {}, k};
      lower_[k] = {"-3 sigma", style, TraceShape::kBound, {}, {}, {}, k};
    }
  }
  void add_bounds(double t, const Eigen::Vector3d& variance) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double bound = 3.0 * std::sqrt(variance(static_cast<Eigen::Index>(k)));
      append(t, bound, upper_[k]);
      append(t, -bound, lower_[k]);
    }
  }
  void add_error(double t, const Eigen::Vector3d& error) {
    for (std::size_t k = 0; k < 3; ++k) {
      append(t, error(static_cast<Eigen::Index>(k)), error_[k]);
    }
  }
  ReportFigure take() {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!error_[k].x.empty()) {
        figure_.traces.push_back(std::move(error_[k]));
      }
      figure_.traces.push_back(std::move(upper_[k]));
      figure_.traces.push_back(std::move(lower_[k]));
    }
    return std::move(figure_);
  }

 private:
  static void append(double t, double value, ReportTrace& trace) {
    trace.x.push_back(t);
    trace.y.push_back(value);
  }
  ReportFigure figure_;
  std::array<ReportTrace, 3> error_, upper_, lower_;
};

ReportTable consistency_table(const RunFolder& run) {
  std::vector<PoseCovariance> covariances;
  std::vector<MatchedPose> known;
  for (const MatchedPose& pose : run.matched) {
    const auto& covariance = run.trajectory[pose.index].covariance;
    if (covariance) {
      known.push_back(pose);
      known.back().index = covariances.size();
      covariances.push_back(*covariance);
    }
  }
  const Consistency c = average_nees(known, covariances, {}, run.trajectory.front().t_ns);
  const auto text = [&c](double PoseNees::*part) {
    return c.anees ? fmt::format("{:.3f}", (*c.anees).*part) : std::string("unknown");
  };
  return {
      "Does the filter know how wrong it is?",
      {"", "pose", "position", "attitude"},
      {{{"ANEES"}, {text(&PoseNees::pose)}, {text(&PoseNees::position)}, {text(&PoseNees::attitude)}},
       {{"frames below the 95 % quantile"},
        {fmt::format("{:.1f} %", 100.0 * c.share_within_95)},
        {"–"},
        {"–"}}},
      "Normalised error squared per degree of freedom, mean over frames later than 1 s: 1 where the filter "
      "is consistent, above where it is too sure of itself."};
}

}  // namespace

ReportSection error_section(const RunFolder& run) {
  const bool judged = !run.matched.empty();
  const std::string caption =
      judged ? "Truth minus estimate, in the world; dotted: three standard deviations of the filter."
             : "Three standard deviations of the filter; no truth is known.";
  ErrorFigure position(
      figure_over_time("position-error", "Position error", {{"x", "m"}, {"y", "m"}, {"z", "m"}}, caption),
      run.method);
  ErrorFigure attitude(
      figure_over_time("attitude-error", "Attitude error", {{"x", "deg"}, {"y", "deg"}, {"z", "deg"}},
                       judged
                           ? "Rotation vector from estimate to truth, about the body's axes; dotted: three "
                             "standard deviations of the filter."
                           : caption),
      run.method);
  for (const TrajectoryRow& row : run.trajectory) {
    if (row.covariance) {
      position.add_bounds(run.seconds(row.t_ns), row.covariance->diagonal().head<3>());
      attitude.add_bounds(run.seconds(row.t_ns),
                          kToDegrees * kToDegrees * row.covariance->diagonal().tail<3>());
    }
  }
  for (const MatchedPose& pose : run.matched) {
    const PoseErrorVector error = pose_error(pose.estimate, pose.truth);
    position.add_error(run.seconds(pose.t_ns), error.head<3>());
    attitude.add_error(run.seconds(pose.t_ns), kToDegrees * error.tail<3>());
  }
  ReportSection section{"errors", judged ? "Errors" : "Uncertainty", {}};
  section.blocks.emplace_back(position.take());
  section.blocks.emplace_back(attitude.take());
  if (judged) {
    section.blocks.emplace_back(consistency_table(run));
  }
  return section;
}

}  // namespace limber::detail
