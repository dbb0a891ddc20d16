// SPDX-License-Identifier: MIT
#include "limber/update/gate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "free_pose.hpp"
#include "judge.hpp"
#include "limber/core/chi_square.hpp"
#include "limber/core/median.hpp"
#include "limber/update/consensus.hpp"
#include "limber/update/constraint.hpp"
#include "limber/update/white_groups.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using detail::are_mismatched, detail::are_two_bodies;
using detail::beside_the_pose, detail::judged_rows;
using detail::Judge, detail::Judged;
using detail::with_free_everything, detail::with_free_pose;

namespace {

/// How far what is constrained may be off, in plausible errors, for finding what most groups agree upon.
constexpr double kWidestOffset = 10.0;

/// Groups that agree with the prediction are no chance, and carry the state.
constexpr std::size_t kEnoughAgree = 5;

/// Groups that tell how far off half of them are; times that, thresholds shrink to; and no further.
constexpr std::size_t kEnoughToCompare = 10;
constexpr double kBeyondHalf = 2.0, kLeastShare = 0.01;

/// Half of the groups are off by no more than so many times what is usual, or something begins to happen.
constexpr double kBeyondUsual = 1.25;

/// The accepted group that exceeds its threshold most, or -1.
Index worst_of(const GateThresholds& thresholds, GateReport& report) {
  Index worst = -1;
  double worst_ratio = 1.0;
  for (std::size_t g = 0; g < report.accepted.size(); ++g) {
    if (!report.accepted[g]) {
      continue;
    }
    report.threshold[g] = thresholds.of(report.dof[g]);
    if (report.dof[g] > 0 && report.distance[g] > worst_ratio * report.threshold[g]) {
      worst_ratio = report.distance[g] / report.threshold[g];
      worst = static_cast<Index>(g);
    }
  }
  return worst;
}

/// What noise is taken for may be much more than a frame shows of it: it stands for all that lasts in a
/// point's pixels, too. How far half of the accepted groups are off beside what it lets expect, or nothing
/// where these are few.
std::optional<double> scatter_of(const GateReport& report, const GateThresholds& widest) {
  std::vector<double> ratios;
  for (std::size_t g = 0; g < report.dof.size(); ++g) {
    if (report.accepted[g] && report.dof[g] > 0) {
      ratios.push_back(report.distance[g] / widest.median_of(report.dof[g]));
    }
  }
  return ratios.size() < kEnoughToCompare ? std::nullopt : std::optional(median(std::move(ratios)));
}

/// A point that is off beside the others shows by theirs; where half of them begin to be off, by what is
/// usual.
GateThresholds as_half_are_off(const GateReport& report, const GateThresholds& widest, double usual) {
  const std::optional<double> scatter = scatter_of(report, widest);
  if (!scatter) {
    return widest;
  }
  return widest.times(std::clamp(kBeyondHalf * std::min(*scatter, usual), kLeastShare, 1.0));
}

/// How far off a group may be.
struct Limits {
  static constexpr double kAnything = std::numeric_limits<double>::infinity();
  GateThresholds widest;
  bool compares;  ///< with half of the groups that are left: where the pose is not known, or not well, its
                  ///< own errors are far from alike
  double usual = kAnything;  ///< so far half of them may be off, beside widest

  /// By what the accepted groups show: beside a mismatch that is still among them parameters that are open
  /// put all others elsewhere.
  [[nodiscard]] GateThresholds of(const GateReport& report) const {
    return compares ? as_half_are_off(report, widest, usual) : widest;
  }
  /// What noise puts a group off by, as far as that is known.
  [[nodiscard]] GateThresholds noise() const { return widest.times(std::clamp(usual, kLeastShare, 1.0)); }
};

/// Drops the worst group as long as one fails. @return false if more than `most` failed
/// @param report  as it was measured last
bool eliminate(Judge& judge, const std::vector<RowGroup>& groups, const Limits& limits, std::size_t most,
               GateReport& report) {
  std::size_t dropped = 0;
  for (;;) {
    const Index worst = worst_of(limits.of(report), report);
    if (worst < 0) {
      return true;
    }
    if (++dropped > most) {
      return false;
    }
    report.accepted[static_cast<std::size_t>(worst)] = false;
    judge.drop(groups[static_cast<std::size_t>(worst)]);
    judge.measure(report);
  }
}

GateReport nothing_refused(std::size_t groups) {
  return {std::vector<bool>(groups, true), std::vector<double>(groups, 0.0), std::vector<double>(groups, 0.0),
          std::vector<Index>(groups, 0)};
}

/// Flags the groups that lie far from what most agree upon. @return how many
std::size_t flag_gross(const WhiteGroups& white, const GateThresholds& thresholds, GateReport& report) {
  const Consensus consensus = find_consensus(white, kWidestOffset);
  std::size_t gross = 0;
  for (std::size_t g = 0; g < white.groups.size(); ++g) {
    const double threshold = thresholds.of(white.groups[g].rows);
    if (consensus.distance[g] > kGrossOutlier * threshold) {
      report.accepted[g] = false;
      report.distance[g] = consensus.distance[g];
      report.dof[g] = white.groups[g].rows;
      report.threshold[g] = threshold;
      ++gross;
    }
  }
  return gross;
}

/// What a prediction that is known says where most groups fail; asked as rarely as that.
struct KnownPrediction {
  std::function<bool(const std::vector<bool>&)> are_mismatched;  // those that are flagged
  std::function<bool(const GateReport&)> knows_the_world;  // those that are left are a body of their own
};

/// @return what refers to all of the arguments
std::optional<KnownPrediction> known_prediction(const Judged& judged, const Innovation& innovation,
                                                const PredictedPose& predicted, const Limits& limits) {
  if (!predicted.known) {
    return std::nullopt;
  }
  return KnownPrediction{
      [&](const std::vector<bool>& some) {
        return predicted.by_pose.size() > 0 &&
               are_mismatched(with_free_everything(judged, innovation, predicted.by_pose).subset(some),
                              limits.widest);
      },
      [&](const GateReport& minority) {
        return are_two_bodies(with_free_pose(judged, innovation), minority, limits.noise());
      }};
}

/// What became of the groups that are no gross outliers, among all.
GateReport with_inner(GateReport flagged, const GateReport& inner) {
  std::size_t k = 0;
  for (std::size_t g = 0; g < flagged.accepted.size(); ++g) {
    if (flagged.accepted[g]) {
      flagged.accepted[g] = inner.accepted[k];
      flagged.distance[g] = inner.distance[k];
      flagged.dof[g] = inner.dof[k];
      flagged.threshold[g] = inner.threshold[k];
      ++k;
    }
  }
  return flagged;
}

/// Goes on where more than `dropped` failed, until enough agree with the prediction; any, beside others that
/// agree on nothing.
/// @param flagged  all groups, of which those judged are the accepted ones
/// @return what became of all, if those that are left may stand
std::optional<GateReport> minority(const KnownPrediction& known, Judge& judge,
                                   const std::vector<RowGroup>& groups, const Limits& limits,
                                   std::size_t dropped, GateReport& judged, const GateReport& flagged) {
  const bool mismatched = known.are_mismatched(std::vector<bool>(flagged.accepted.size(), true));
  const std::size_t left = mismatched ? 0 : kEnoughAgree;
  if (groups.size() < dropped + left ||
      !eliminate(judge, groups, limits, groups.size() - dropped - left, judged)) {
    return std::nullopt;
  }
  GateReport out = with_inner(flagged, judged);
  if (!mismatched && !known.knows_the_world(out)) {
    return std::nullopt;
  }
  out.most_mismatched = mismatched;
  return out;
}

/// Without the gross outliers, the others in turn.
GateReport gate_robustly(const Judged& judged, const GateReport& flagged, std::size_t gross,
                         const Limits& limits, const std::optional<KnownPrediction>& known) {
  const Judged rest = judged.subset(flagged.accepted);
  Judge judge(rest);
  GateReport inner = nothing_refused(rest.groups.size());
  const std::size_t half = judged.groups.size() / 2;
  const std::size_t most = gross <= half ? half - gross : rest.groups.size() / 4;
  if (!judge.valid()) {
    return with_inner(flagged, inner);
  }
  judge.measure(inner);
  if (eliminate(judge, rest.groups, limits, most, inner)) {
    return with_inner(flagged, inner);
  }
  GateReport all = inner;
  all.accepted.assign(rest.groups.size(), true);
  if (known) {
    if (auto out = minority(*known, judge, rest.groups, limits, most, inner, flagged)) {
      return *std::move(out);
    }
  }
  GateReport out = with_inner(flagged, all);
  out.overruled = true;
  return out;
}

/// Where some group fails.
/// @param report  all groups as they are measured
/// @param trusts  nothing is constrained
GateReport refuse(const Judged& judged, Judge& judge, GateReport report, const Limits& limits, bool trusts,
                  const std::optional<KnownPrediction>& known) {
  const std::size_t groups = judged.groups.size(), half = groups / 2;
  GateReport flagged = nothing_refused(groups);
  const std::size_t gross = flag_gross(judge.white(), limits.of(report), flagged);
  // What is constrained cannot put most points far from each other; what is trusted can.
  if (gross > 0 && (trusts ? 2 : 3) * gross <= (trusts ? 1 : 2) * groups) {
    return gate_robustly(judged, flagged, gross, limits, known);
  }
  if (eliminate(judge, judged.groups, limits, half, report)) {
    return report;
  }
  if (known) {
    if (auto out = minority(*known, judge, judged.groups, limits, half, report, nothing_refused(groups))) {
      return *std::move(out);
    }
  }
  report.accepted.assign(groups, true);
  report.overruled = true;
  return report;
}

/// Where half of the groups are farther off than usual: something moves, because no pose and no parameters
/// put those that are refused and the others where they are. An input that fails moves all alike.
bool is_beyond_usual(const Judged& judged, const Innovation& innovation, const PredictedPose& predicted,
                     const Limits& limits, const GateReport& report) {
  return !report.overruled &&
         are_two_bodies(with_free_everything(judged, innovation, predicted.by_pose), report, limits.noise());
}

/// Most groups are refused, and they do not agree with each other, as a body that moves would.
bool refused_are_mismatched(const KnownPrediction& known, const GateReport& report) {
  std::vector<bool> refused = report.accepted;
  refused.flip();
  return report.most_refused() && known.are_mismatched(refused);
}

}  // namespace

GateThresholds::GateThresholds(double probability) : threshold_(probability), median_(0.5) {}

GateThresholds GateThresholds::times(double share) const {
  GateThresholds out = *this;
  out.share_ *= share;
  return out;
}

GateThresholds::Quantiles::Quantiles(double p) : probability(p), of_point{} {
  for (std::size_t dof = 1; dof < of_point.size(); ++dof) {
    of_point[dof] = chi_square_quantile(p, static_cast<double>(dof));
  }
}

double GateThresholds::Quantiles::of(Index dof) const {
  const auto at = static_cast<std::size_t>(dof);
  return at < of_point.size() ? of_point[at] : chi_square_quantile(probability, static_cast<double>(dof));
}

bool GateReport::most_refused() const {
  return 2 * std::ranges::count(accepted, false) > std::ssize(accepted);
}

bool GateReport::all_accepted() const {
  return std::find(accepted.begin(), accepted.end(), false) == accepted.end();
}

GateReport gate(const Innovation& innovation, const std::vector<RowGroup>& groups,
                const ParameterErrorModel& model, const GateThresholds& widest,
                const PredictedPose& predicted) {
  const bool known_well = predicted.known && predicted.by_pose.size() > 0;
  Judged judged = judged_rows(innovation, groups, model);
  judged.asks_others = known_well;
  if (predicted.P.size() > 0) {
    judged = beside_the_pose(std::move(judged), innovation, predicted.P);
  }
  GateReport report = nothing_refused(groups.size());
  Judge judge(judged);
  if (!judge.valid()) {
    return report;  // the update will say that S is singular
  }
  judge.measure(report);
  Limits limits{widest, predicted.known};
  const std::optional<double> scatter = scatter_of(report, widest);
  if (!known_well) {
    limits = {limits.of(report), false};
  } else if (predicted.usual_scatter) {
    limits.usual = kBeyondUsual * *predicted.usual_scatter;
  }
  report.scatter = scatter;
  if (worst_of(limits.of(report), report) < 0) {
    return report;
  }
  const bool trusts = model.constrained.cols() == 0;
  const std::optional<KnownPrediction> known = known_prediction(judged, innovation, predicted, limits);
  GateReport out = refuse(judged, judge, report, limits, trusts, known);
  if (limits.usual < scatter.value_or(0.0) && !is_beyond_usual(judged, innovation, predicted, limits, out)) {
    limits.usual = Limits::kAnything;
    Judge anew(judged);
    out = refuse(judged, anew, std::move(report), limits, trusts, known);
  }
  out.most_mismatched = out.most_mismatched || (known && refused_are_mismatched(*known, out));
  if (predicted.rig.size() > 0 && model.constrained.cols() == 0) {
    const bool contradicted = out.overruled;
    out = gate(innovation, groups, {predicted.rig, model.white_covariance}, widest,
               {predicted.known, predicted.by_pose, predicted.P, {}, {}});
    out.overruled = out.overruled || contradicted;
  }
  out.scatter = scatter;
  return out;
}

}  // namespace limber
