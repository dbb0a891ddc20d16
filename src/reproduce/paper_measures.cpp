// SPDX-License-Identifier: MIT
#include "reproduce/paper_measures.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "limber/core/median.hpp"
#include "limber/study/study_plan.hpp"

namespace limber::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kWalkTolerance = 1e-3;  // relative; walks are written with one digit
constexpr double kScaleTolerance = 0.02;

using MaybeScore = std::optional<Score>;
using ScoreOf = MaybeScore (*)(const Measured&);

Score score(const Measured& m, double value, const char* unit) {
  const MethodSummary& s = m.method->summary;
  if (s.diverged > 0) {
    return {kInfinity, fmt::format("{} diverged in {} of {} runs", m.label(), s.diverged, s.runs)};
  }
  return {value, fmt::format("{} {:.3g} {}", m.label(), value, unit)};
}

MaybeScore score_of(const Measured& m, const std::optional<double>& value, const char* unit) {
  if (!value && m.method->summary.diverged == 0) {
    return std::nullopt;
  }
  return score(m, value.value_or(kInfinity), unit);
}

/// Mean of a curve over the instants in [begin, end].
std::optional<double> mean_between(const Measured& m, CurveQuantity quantity, double begin, double end) {
  const StudyCurve* const curve = m.curve(quantity);
  double sum = 0.0;
  std::size_t count = 0;
  const std::vector<double>& times = m.study_case->info.frame_times;
  for (std::size_t k = 0; curve != nullptr && k < curve->mean.size(); ++k) {
    if (times[k] >= begin && times[k] <= end && std::isfinite(curve->mean[k])) {
      sum += curve->mean[k];
      ++count;
    }
  }
  return count > 0 ? std::optional(sum / static_cast<double>(count)) : std::nullopt;
}

/// Median over the runs of the median time per frame [ms].
std::optional<double> median_ms(const Measured& m) {
  std::vector<double> times;
  for (const StudyRun& run : m.method->runs) {
    if (run.figures.ms_per_frame_p50) {
      times.push_back(*run.figures.ms_per_frame_p50);
    }
  }
  if (times.empty()) {
    return std::nullopt;
  }
  return upper_median(std::move(times));
}

double last_time(const Measured& m) { return m.study_case->info.frame_times.back(); }

/// "(i) none, with IMU: " before a score that stands beside one of another case.
std::string case_prefix(const Measured& m, const Measured& beside) {
  if (m.study_case == beside.study_case) {
    return "";
  }
  const auto paper_case = paper_case_of(m.study_case->info);
  return paper_case ? to_string(*paper_case) + ": " : "";
}

/// Compares two scores with a rule; not known where one is missing.
template <typename Rule>
Outcome compare(const Measured& a, const Measured& b, ScoreOf score_of, Rule rule) {
  const MaybeScore x = score_of(a), y = score_of(b);
  if (!x || !y) {
    return {(x ? b : a).label() + " not measured", std::nullopt};
  }
  return {case_prefix(a, b) + x->text + (a.study_case == b.study_case ? ", " : "; ") + case_prefix(b, a) +
              y->text,
          rule(x->value, y->value)};
}

bool within(double factor, double a, double b) {
  return std::isfinite(a) && std::isfinite(b) && std::max(a, b) <= factor * std::min(a, b);
}

bool within_same(double a, double b) { return within(kSame, a, b); }

/// Root mean square error of the points in the map between two instants.
MaybeScore landmark_score(const Measured& m, double begin, double end) {
  const auto square = mean_between(m, CurveQuantity::kLandmarkSquaredError, begin, end);
  return score_of(m, square ? std::optional(std::sqrt(*square)) : std::nullopt, "m");
}

bool below(double a, double b) { return a < b; }

}  // namespace

Outcome all_of(const std::vector<Outcome>& outcomes) {
  Outcome out{"", true};
  for (const Outcome& outcome : outcomes) {
    out.measured += (out.measured.empty() ? "" : "\n") + outcome.measured;
    if (outcome.holds == false || out.holds == false) {
      out.holds = false;
    } else if (!outcome.holds) {
      out.holds.reset();
    }
  }
  return out;
}

const StudyCurve* Measured::curve(CurveQuantity quantity) const {
  const auto it = method->curves.find(quantity);
  return it == method->curves.end() ? nullptr : &it->second;
}

PaperStudy::PaperStudy(const StudyResults& study) : results(study) {
  for (const StudyCaseResults& study_case : results.cases) {
    cases.push_back(paper_case_of(study_case.info));
  }
}

bool has_paper_methods(const StudyCaseResults& study_case) {
  return find_method(study_case, MainMethod::kEkf) && find_method(study_case, MainMethod::kEkfFull) &&
         find_method(study_case, MainMethod::kLcekf);
}

const StudyCaseResults* find_case(const PaperStudy& study, const PaperCase& paper_case) {
  const StudyCaseResults* found = nullptr;
  for (std::size_t k = 0; k < study.cases.size(); ++k) {
    const StudyCaseResults& candidate = study.results.cases[k];
    if (study.cases[k] == paper_case && has_paper_methods(candidate) &&
        candidate.info.finished > (found == nullptr ? 0 : found->info.finished)) {
      found = &candidate;
    }
  }
  return found;
}

std::optional<Measured> find_method(const StudyCaseResults& study_case, MainMethod method) {
  const StudyMethodResults* const found = find_main_method(study_case, method);
  return found != nullptr ? std::optional(Measured{&study_case, found}) : std::nullopt;
}

std::optional<Measured> find_walk(const PaperStudy& study, double rotation_rad2, double translation_mm2) {
  const auto is_near = [](double value, double wanted) {
    return std::abs(value - wanted) <= kWalkTolerance * wanted;
  };
  for (std::size_t k = 0; k < study.cases.size(); ++k) {
    const StudyCaseResults& study_case = study.results.cases[k];
    if (study_case.info.finished == 0 || study.cases[k] != PaperCase{PaperNoise::kSinus, false}) {
      continue;
    }
    for (const StudyMethodResults& method : study_case.methods) {
      if (method.variant.method != Method::kEkfFull) {
        continue;
      }
      const RunOptions options =
          run_options(study_case.info.scenario, method.variant, study_case.info.start, study.results.seed, 0);
      const RigParameters per_10_ms = 0.01 * options.theta_walk.value_or(RigParameters::Zero());
      if (is_near(per_10_ms(0), rotation_rad2) && is_near(1e6 * per_10_ms(3), translation_mm2)) {
        return Measured{&study_case, &method};
      }
    }
  }
  return std::nullopt;
}

MaybeScore position_score(const Measured& m) { return score_of(m, m.method->summary.position_rmse_m, "m"); }

MaybeScore attitude_score(const Measured& m) {
  return score_of(m, m.method->summary.attitude_rmse_deg, "deg");
}

MaybeScore landmark_start_score(const Measured& m) { return landmark_score(m, 0.0, kStart); }

MaybeScore landmark_end_score(const Measured& m) {
  return landmark_score(m, last_time(m) - kEnd, last_time(m));
}

Outcome position_at_most(const Measured& a, double factor, const Measured& b) {
  return compare(a, b, position_score,
                 [factor](double x, double y) { return std::isfinite(x) && x <= factor * y; });
}

Outcome better(const Measured& a, const Measured& b) {
  return all_of({compare(a, b, position_score, below), compare(a, b, attitude_score, below)});
}

Outcome same_localization(const Measured& a, const Measured& b) {
  return all_of({compare(a, b, position_score, within_same), compare(a, b, attitude_score, within_same)});
}

Outcome same_position(const std::vector<Measured>& all, double factor) {
  std::vector<std::string> texts;
  double smallest = kInfinity, largest = 0.0;
  bool known = true;
  for (const Measured& m : all) {
    const MaybeScore s = position_score(m);
    const Measured& beside = &m == &all.front() ? all.back() : all.front();
    texts.push_back(case_prefix(m, beside) + (s ? s->text : m.label() + " not measured"));
    smallest = std::min(smallest, s ? s->value : kInfinity);
    largest = std::max(largest, s ? s->value : kInfinity);
    known = known && s;
  }
  if (std::adjacent_find(texts.begin(), texts.end(), std::not_equal_to<>()) == texts.end()) {
    texts.resize(1);  // one and the same
  }
  return {fmt::format("{}", fmt::join(texts, "; ")),
          known ? std::optional(within(factor, smallest, largest)) : std::nullopt};
}

Outcome landmarks_start_better(const Measured& a, const Measured& b) {
  return compare(a, b, landmark_start_score, below);
}

Outcome landmarks_end_the_same(const Measured& a, const Measured& b) {
  return compare(a, b, landmark_end_score, within_same);
}

Outcome diverges(const Measured& m) {
  const StudyCurve* const error = m.curve(CurveQuantity::kPositionSquaredError);
  const StudyCurve* const variance = m.curve(CurveQuantity::kPositionVariance);
  std::size_t outside = 0, instants = 0;
  for (std::size_t k = 0; error != nullptr && variance != nullptr && k < error->mean.size(); ++k) {
    if (std::isfinite(error->mean[k]) && std::isfinite(variance->mean[k])) {
      ++instants;
      outside += error->mean[k] > 9.0 * variance->mean[k] ? 1 : 0;
    }
  }
  const MethodSummary& s = m.method->summary;
  if (s.diverged == 0 && instants == 0) {
    return {m.label() + " not measured", std::nullopt};
  }
  std::string text = m.label();
  if (const MaybeScore position = position_score(m)) {
    text = position->text;  // with the runs that diverged
  }
  double share = 0.0;
  if (instants > 0) {
    share = static_cast<double>(outside) / static_cast<double>(instants);
    text += fmt::format(", beyond 3σ at {:.0f} % of the instants", 100.0 * share);
  }
  return {text, s.diverged > 0 || share > 0.5};
}

Outcome does_not_diverge(const Measured& m) {
  Outcome out = diverges(m);
  if (out.holds) {
    out.holds = !*out.holds;
  }
  return out;
}

Outcome drifts(const Measured& m) {
  const double quarter = 0.25 * last_time(m);
  const auto first = mean_between(m, CurveQuantity::kPositionSquaredError, 0.0, quarter);
  const auto last = mean_between(m, CurveQuantity::kPositionSquaredError, 3.0 * quarter, 4.0 * quarter);
  if (!first || !last) {
    return {m.label() + " not measured", std::nullopt};
  }
  return {fmt::format("{}: position error {:.3g} m in the first quarter, {:.3g} m in the last", m.label(),
                      std::sqrt(*first), std::sqrt(*last)),
          *last > *first};
}

Outcome time_at_most(const Measured& a, double factor, const Measured& b) {
  const auto x = median_ms(a), y = median_ms(b);
  if (!x || !y) {
    return {(x ? b : a).label() + " not timed", std::nullopt};
  }
  return {fmt::format("{} {:.3g} ms, {} {:.3g} ms", a.label(), *x, b.label(), *y), *x <= factor * *y};
}

Outcome keeps_scale(const Measured& m) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const StudyRun& run : m.method->runs) {
    if (run.figures.scale) {
      sum += *run.figures.scale;
      squares += (*run.figures.scale - 1.0) * (*run.figures.scale - 1.0);
      count += 1.0;
    }
  }
  if (count == 0.0) {
    return {m.label() + " not measured", std::nullopt};
  }
  const double departure = std::sqrt(squares / count);
  return {fmt::format("{}: scale {:.4f} ({:.2f} % off)", m.label(), sum / count, 100.0 * departure),
          departure <= kScaleTolerance};
}

}  // namespace limber::detail
