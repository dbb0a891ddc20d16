// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "limber/simulate/decalibration.hpp"
#include "report/main_methods.hpp"
#include "study_sections.hpp"

namespace limber::detail {
namespace {

constexpr std::array<const char*, 6> kAxisNames = {"α_x", "α_y", "α_z", "t_x", "t_y", "t_z"};

ReportFigure new_figure(const CaseContext& context, const std::string& id, const std::string& title,
                        std::vector<ReportAxis> y, const std::string& caption) {
  ReportFigure figure;
  figure.id = context.slug + "-" + id;
  figure.title = title;
  figure.caption = caption;
  figure.x = {"time", "s"};
  figure.y = std::move(y);
  figure.half_width = true;
  figure.variants = method_variants(context.results);
  return figure;
}

/// factor * mean of a curve over time; no trace if the method has none.
void add_curve(const CaseContext& context, const StudyMethodResults& method, CurveQuantity quantity,
               double factor, TraceShape shape, ReportFigure& figure) {
  const auto it = method.curves.find(quantity);
  if (it == method.curves.end()) {
    return;
  }
  const std::string& label = method.summary.label;
  ReportTrace trace{shape == TraceShape::kBound ? label + " 3σ" : label, label, shape, {}, {}, {}, 0};
  trace.x = context.results.info.frame_times;
  for (const double mean : it->second.mean) {
    trace.y.push_back(factor * mean);
  }
  figure.traces.push_back(std::move(trace));
}

/// A mean squared error, and 9 times the mean variance beside it.
ReportFigure squared_error(const CaseContext& context, const char* id, const char* title, const char* unit,
                           CurveQuantity error, CurveQuantity variance) {
  ReportFigure figure =
      new_figure(context, id, title, {{"mean squared error", unit}},
                 "Full: mean squared error over the runs. Dotted: 3σ, that is 9 times the mean "
                 "variance that the filter claims.");
  figure.log_switch = true;
  for (const StudyMethodResults& method : context.results.methods) {
    add_curve(context, method, error, 1.0, TraceShape::kLine, figure);
    add_curve(context, method, variance, 9.0, TraceShape::kBound, figure);
  }
  return figure;
}

ReportFigure landmark_figure(const CaseContext& context) {
  ReportFigure figure =
      new_figure(context, "landmarks", "Landmark error", {{"mean squared error", "m²"}},
                 "Mean over the runs and over the points that are in the map at that instant.");
  figure.log_switch = figure.starts_in_log = true;
  for (const StudyMethodResults& method : context.results.methods) {
    add_curve(context, method, CurveQuantity::kLandmarkSquaredError, 1.0, TraceShape::kLine, figure);
  }
  return figure;
}

ReportFigure consistency_figure(const CaseContext& context) {
  ReportFigure figure = new_figure(context, "nees", "Consistency of the pose", {{"mean NEES / 6", ""}},
                                   "1: the filter knows how wrong it is; above: too sure of itself.");
  figure.log_switch = figure.starts_in_log = true;
  for (const StudyMethodResults& method : context.results.methods) {
    add_curve(context, method, CurveQuantity::kPoseNees, 1.0 / 6.0, TraceShape::kLine, figure);
  }
  const auto& methods = context.results.methods;
  const auto known = std::find_if(methods.begin(), methods.end(),
                                  [](const auto& m) { return m.summary.anees_interval.has_value(); });
  if (known != methods.end() && !context.results.info.frame_times.empty()) {
    const Interval interval = *known->summary.anees_interval;
    const std::vector<double>& times = context.results.info.frame_times;
    for (const double bound : {interval.lower, interval.upper}) {
      figure.traces.push_back({"95 % of a consistent filter",
                               "band",
                               TraceShape::kLine,
                               {times.front(), times.back()},
                               {bound, bound},
                               {},
                               0});
    }
    figure.caption +=
        fmt::format(" Between the lines lie 95 % of the instants of a consistent filter over {} runs.",
                    known->summary.runs - known->summary.diverged);
  }
  return figure;
}

/// Three of the six parameters: the truth of run 0, and what filters with theta in the state make of it.
ReportFigure calibration_figure(const CaseContext& context, std::size_t first, const char* id,
                                const char* title, const char* unit, double factor) {
  std::vector<ReportAxis> y;
  for (std::size_t k = 0; k < 3; ++k) {
    y.push_back({kAxisNames[first + k], unit});
  }
  ReportFigure figure = new_figure(context, id, title, std::move(y),
                                   "δ(t), by which the true rig departs from the one that filters assume.");
  const StudyCaseInfo& info = context.results.info;
  const Decalibration delta(info.scenario.decalibration, info.scenario.duration, context.seed, 0);
  bool estimated = false;
  for (std::size_t k = 0; k < 3; ++k) {
    ReportTrace truth{"truth", "truth", TraceShape::kLine, info.frame_times, {}, {}, k};
    for (const double t : info.frame_times) {
      const RigParameters value = delta.at(std::llround(1e9 * t));
      truth.y.push_back(factor * value(static_cast<Eigen::Index>(first + k)));
    }
    figure.traces.push_back(std::move(truth));
    for (const StudyMethodResults& method : context.results.methods) {
      const auto mean = method.curves.find(theta_axis(CurveQuantity::kDeltaAx, first + k));
      const auto variance = method.curves.find(theta_axis(CurveQuantity::kThetaVarianceAx, first + k));
      if (mean == method.curves.end() || variance == method.curves.end()) {
        continue;
      }
      estimated = true;
      const std::string& label = method.summary.label;
      ReportTrace estimate{label, label, TraceShape::kLine, info.frame_times, {}, {}, k};
      ReportTrace upper{label + " +3σ", label, TraceShape::kBound, info.frame_times, {}, {}, k};
      ReportTrace lower{label + " −3σ", label, TraceShape::kBound, info.frame_times, {}, {}, k};
      for (std::size_t n = 0; n < info.frame_times.size(); ++n) {
        const double bound = 3.0 * std::sqrt(variance->second.mean[n]);
        estimate.y.push_back(factor * mean->second.mean[n]);
        upper.y.push_back(factor * (mean->second.mean[n] + bound));
        lower.y.push_back(factor * (mean->second.mean[n] - bound));
      }
      for (ReportTrace* trace : {&estimate, &upper, &lower}) {
        figure.traces.push_back(std::move(*trace));
      }
    }
  }
  std::erase_if(figure.variants,
                [](const FigureVariant& v) { return v.label == "without ekf" || v.label == "lcekf alone"; });
  if (estimated) {
    figure.caption += " Estimates: mean over the runs; dotted: 3σ around it.";
  }
  return figure;
}

ReportTrace points(const std::string& name, const std::string& style, TraceShape shape,
                   const std::vector<Eigen::Vector3d>& positions) {
  ReportTrace trace{name, style, shape, {}, {}, {}, 0};
  for (const Eigen::Vector3d& p : positions) {
    trace.x.push_back(p.x());
    trace.y.push_back(p.y());
    trace.z.push_back(p.z());
  }
  return trace;
}

/// Of the frames of a path; of a run that broke down, the first ones.
std::vector<double> times_of(std::size_t frames, const StudyCaseInfo& info) {
  if (frames > info.frame_times.size()) {
    return {};
  }
  return {info.frame_times.begin(), info.frame_times.begin() + static_cast<std::ptrdiff_t>(frames)};
}

ReportFigure path_figure(const CaseContext& context) {
  const ExampleRun& example = context.results.example;
  ReportFigure figure = new_figure(context, "path", "Path and landmarks of run 0", {{"y", "m"}, {"z", "m"}},
                                   "Drag to turn, scroll to come closer.");
  figure.kind = FigureKind::kSpace;
  figure.x = {"x", "m"};
  figure.half_width = false;
  figure.traces.push_back(points("landmarks", "landmarks", TraceShape::kDots, example.landmarks));
  figure.traces.push_back(points("truth", "truth", TraceShape::kLine, example.truth));
  figure.traces.back().t = times_of(example.truth.size(), context.results.info);
  for (std::size_t k = 0; k < example.estimate.size(); ++k) {
    const std::string& label = context.results.methods[k].summary.label;
    figure.traces.push_back(points(label, label, TraceShape::kLine, example.estimate[k]));
    figure.traces.back().t = times_of(example.estimate[k].size(), context.results.info);
  }
  FigureVariant alone{"path alone", figure.variants.front().hidden_styles};
  alone.hidden_styles.emplace_back("landmarks");
  figure.variants.push_back(std::move(alone));
  return figure;
}

/// Leaves out of the variants what makes no difference here; a single one is no choice, unless it hides.
void fit_variants(ReportFigure& figure) {
  std::vector<FigureVariant> fitting;
  for (FigureVariant& variant : figure.variants) {
    std::erase_if(variant.hidden_styles, [&figure](const std::string& style) {
      return std::none_of(figure.traces.begin(), figure.traces.end(),
                          [&style](const ReportTrace& trace) { return trace.style == style; });
    });
    const bool is_known = std::any_of(fitting.begin(), fitting.end(), [&variant](const auto& known) {
      return known.hidden_styles == variant.hidden_styles;
    });
    if (!is_known) {
      fitting.push_back(std::move(variant));
    }
  }
  if (fitting.size() == 1 && fitting.front().hidden_styles.empty()) {
    fitting.clear();
  }
  figure.variants = std::move(fitting);
}

}  // namespace

std::vector<FigureVariant> method_variants(const StudyCaseResults& results) {
  const auto show = [&results](const std::string& name, const std::vector<std::string>& shown) {
    FigureVariant variant{name, {}};
    for (const StudyMethodResults& method : results.methods) {
      if (std::find(shown.begin(), shown.end(), method.summary.label) == shown.end()) {
        variant.hidden_styles.push_back(method.summary.label);
      }
    }
    return variant;
  };
  const FigureVariant all{"all", {}};
  const auto* const ekf = find_main_method(results, MainMethod::kEkf);
  const auto* const ekf_full = find_main_method(results, MainMethod::kEkfFull);
  const auto* const lcekf = find_main_method(results, MainMethod::kLcekf);
  if (ekf == nullptr || ekf_full == nullptr || lcekf == nullptr) {
    return {all};
  }
  // The paper's (a) and (b), of Figures 6 to 9 and of Figure 10.
  std::vector<FigureVariant> variants = {
      show("paper", {ekf->summary.label, ekf_full->summary.label, lcekf->summary.label}),
      show("without ekf", {ekf_full->summary.label, lcekf->summary.label}),
      show("lcekf alone", {lcekf->summary.label})};
  std::vector<std::string> walks = {lcekf->summary.label};
  for (const StudyMethodResults& method : results.methods) {
    if (method.variant.method == Method::kEkfFull) {
      walks.push_back(method.summary.label);
    }
  }
  if (walks.size() > 2) {  // Figures 15 to 18
    variants.push_back(show("walks", walks));
  }
  if (variants.front().hidden_styles.empty()) {
    variants.front() = all;
  } else {
    variants.push_back(all);
  }
  return variants;
}

std::vector<ReportFigure> case_figures(const CaseContext& context) {
  std::vector<ReportFigure> figures;
  figures.push_back(squared_error(context, "position", "Position error", "m²",
                                  CurveQuantity::kPositionSquaredError, CurveQuantity::kPositionVariance));
  figures.push_back(squared_error(context, "attitude", "Attitude error", "rad²",
                                  CurveQuantity::kAttitudeSquaredError, CurveQuantity::kAttitudeVariance));
  figures.push_back(landmark_figure(context));
  figures.push_back(consistency_figure(context));
  const double degrees = 1.0 / kDegree;
  figures.push_back(
      calibration_figure(context, 0, "calibration-rotation", "Calibration: rotation", "deg", degrees));
  figures.push_back(
      calibration_figure(context, 3, "calibration-translation", "Calibration: translation", "m", 1.0));
  figures.push_back(path_figure(context));
  for (ReportFigure& figure : figures) {
    fit_variants(figure);
  }
  return figures;
}

}  // namespace limber::detail
