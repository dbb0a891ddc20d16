// SPDX-License-Identifier: MIT
#include "limber/health/calibration_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"
#include "limber/health/drift_test.hpp"

namespace limber {

namespace {

constexpr std::size_t kMostWindows = 400;                     // that are kept; then neighbours are merged
constexpr double kDrifts = 0.5;                               // false alarms of drifts, by those of steps
constexpr double kPlaces = kLongestStep - kShortestStep + 1;  // of a moment, counted from the end
constexpr std::size_t kFewestOfADrift = 5;                    // windows
constexpr double kDoubt = 0.01;                               // p-value of a drift that is reckoned with
constexpr std::array kEarlyLooks = {0.2, 0.4, 0.7};           // at the first window, as shares of its length
constexpr double kSeenToMove = 3.0;                           // sigmas of the speed
constexpr double kLargestScale = 0.5;  // relative error of a metre: no sensor is believed to be worse

RigParameters px_by_axis(const BetaEstimate& estimate, const RigParameters& theta) {
  const NormalEquations::Vector px = estimate.epipolar.diagonal().cwiseMax(0.0).cwiseSqrt();
  return px.head<6>().cwiseQuotient(plausible_error(theta.tail<3>().norm()));
}

/// A rig that moves is no better than it is on average.
void count_movement(CalibrationState& out) {
  if (out.tracks < kFewestTracks) {
    return;
  }
  out.verdict = worst(out.verdict, worst(out.by_movement, out.by_depth_movement));
  if (!out.named && out.moves()) {
    out.named = out.moving_axis();
  }
}

void judge_movement(const std::vector<RigEvidence>& windows, const RigParameters& theta,
                    const Tolerance& tolerance, CalibrationState& out) {
  std::vector<FrameHalves> blocks;
  std::vector<DepthHalves> depth_blocks;
  for (const RigEvidence& window : windows) {
    blocks.insert(blocks.end(), window.blocks.begin(), window.blocks.end());
    depth_blocks.insert(depth_blocks.end(), window.depth_blocks.begin(), window.depth_blocks.end());
  }
  out.movement = movement_of(blocks, out.vergence);
  out.depth_movement = depth_movement_of(depth_blocks, theta, tolerance.baselines);
  out.by_movement = judge(out.movement.px, tolerance.epipolar_px);
  out.by_depth_movement = out.deep_tracks < kFewestTracks ? HealthVerdict::kCannotTell
                                                          : judge(out.depth_movement.share, tolerance.depth);
  count_movement(out);
}

/// False alarms a window.
double alarms_of_window(const WatchOptions& options) {
  return options.false_alarms_per_hour * options.window_s / 3600.0;
}

/// Of a drift that is not relevant: anything up to that, uniformly, in depth and on the epipolar lines.
NormalEquations::Matrix drift_not_looked_for(NormalEquations::Matrix epipolar, const RigParameters& theta,
                                             bool metric, const Tolerance& tolerance) {
  constexpr auto kLens = NormalEquations::kLens;
  const Eigen::Index vergence = vergence_axis(theta);
  // On the lines vergence is taken for what a lens does: that drifts with it.
  epipolar(kLens, kLens) = epipolar(vergence, vergence);
  NormalEquations::Vector depth = NormalEquations::Vector::Zero();
  depth.head<6>() =
      visible_slope(theta, metric, tolerance).cwiseProduct(plausible_error(theta.tail<3>().norm()));
  const auto variance = [](double ok) { return kRelevantShare * kRelevantShare * ok * ok / 3.0; };
  const NormalEquations::Matrix information = epipolar / variance(tolerance.epipolar_px.ok) +
                                              depth * depth.transpose() / variance(tolerance.depth.ok) +
                                              NormalEquations::kPrior * NormalEquations::Matrix::Identity();
  return Cholesky(information).inverse();
}

/// What windows vary by is known with no more degrees of freedom than windows are left, without a state each,
/// and two of expected scatter. That limits those of the variance by the share that it has in it.
Scatters of_windows(Scatters scatters, const BetaEstimate& step, const ChangeWays& ways, std::size_t windows,
                    std::size_t states) {
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const NormalEquations::Vector& along = ways[k].along;
    const double share =
        along.dot(step.between * along) / std::max(along.dot(step.covariance * along), 1e-30);
    const auto left = static_cast<double>(windows + 3 - 2 * states);
    scatters[k].dof = std::min(scatters[k].dof, left / std::max(share * share, 1e-6));
  }
  return scatters;
}

/// The larger factor and the fewer degrees of freedom of each way.
Scatters worse(const Scatters& a, const Scatters& b) {
  Scatters out;
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k] = {std::max(a[k].factor, b[k].factor), std::min(a[k].dof, b[k].dof)};
  }
  return out;
}

/// The line through windows that are enough for one.
struct Line {
  BetaTrend trend;
  double chance = 0.0;
  std::size_t windows = 0;
};

Line line_through(const std::vector<RigEvidence>& windows, const RigParameters& theta, bool metric,
                  const Tolerance& tolerance) {
  const BetaTrend trend = robust_trend(windows, theta, metric);
  return {trend, chance_of_drift(windows, trend, theta, metric, tolerance), windows.size()};
}

/// The drift that is no chance; or one that was none a window ago, and is still reckoned with.
std::optional<RigDrift> drift_of(const Line& line, const RigParameters& theta, const WatchOptions& options,
                                 bool drifts) {
  const double limit = kDrifts * alarms_of_window(options) / drift_tests_of_window(line.windows);
  if (line.chance < (drifts ? std::max(limit, kDoubt) : limit)) {
    return RigDrift{line.trend.change.rig(theta), line.trend.seconds, 0};
  }
  return std::nullopt;
}

/// The error at the end.
BetaEstimate estimate_at_end(const Line& line, const RigParameters& theta, bool metric,
                             const Tolerance& tolerance) {
  const BetaTrend& trend = line.trend;
  return line.chance < kDoubt ? trend.now
                              : with_drift_within(trend, drift_not_looked_for(trend.change.epipolar, theta,
                                                                              metric, tolerance));
}

}  // namespace

bool CalibrationState::moves() const { return is_wrong(by_movement) || is_wrong(by_depth_movement); }

std::size_t CalibrationState::moving_axis() const {
  const Eigen::Index axis = is_wrong(by_movement) ? movement.axis : depth_movement.axis;
  return static_cast<std::size_t>(axis);
}

CalibrationState state_of(const std::vector<RigEvidence>& windows, const RigParameters& theta, bool metric,
                          const WatchOptions& options, std::size_t chosen, bool drifts) {
  CalibrationState out;
  out.from_ns = windows.front().from_ns;
  out.to_ns = windows.back().to_ns;
  out.windows = windows.size();
  out.vergence = vergence_axis(theta);
  for (const RigEvidence& window : windows) {
    out.points += window.points;
    out.tracks += window.track_count;
    out.deep += window.deep;
    out.deep_tracks += window.deep_tracks;
  }
  std::optional<Line> line;
  if (windows.size() >= kFewestOfADrift) {
    line = line_through(windows, theta, metric, options.tolerance);
  }
  const BetaEstimate estimate = line ? estimate_at_end(*line, theta, metric, options.tolerance)
                                     : robust_estimate(windows, theta, metric);
  judge_estimate(estimate, theta, metric, options.tolerance, out);
  if (windows.size() >= chosen + kFewestOfADrift) {
    if (chosen > 0) {
      line = line_through({windows.begin() + static_cast<std::ptrdiff_t>(chosen), windows.end()}, theta,
                          metric, options.tolerance);
    }
    out.drift = drift_of(*line, theta, options, drifts);
  }
  if (out.drift) {
    out.drift->named = static_cast<std::size_t>(most_likely_axis(out.drift->change, out.bands));
  }
  if (!out.scale_is_lost) {
    judge_movement(windows, theta, options.tolerance, out);
  }
  return out;
}

void judge_estimate(const BetaEstimate& estimate, const RigParameters& theta, bool metric,
                    const Tolerance& tolerance, CalibrationState& out) {
  const RigParameters slope = visible_slope(theta, metric, tolerance);
  out.scale_is_lost = !metric && loses_scale(estimate, theta);
  out.whole = out.scale_is_lost ? with_unknown_length(estimate, theta) : estimate;
  out.estimate = out.whole.rig(theta);
  out.effect = effect_of(out.whole, theta, slope);
  out.bands = axis_bands(tolerance, px_by_axis(out.whole, theta), slope);
  out.axes.fill(HealthVerdict::kCannotTell);
  if (out.tracks < kFewestTracks) {
    return;
  }
  const bool few_depths = out.deep_tracks < kFewestTracks, depths = !few_depths && !out.scale_is_lost;
  if (few_depths) {  // lines alone are asked, which hardly know of a vergence
    out.effect.epipolar_px = effect_of(with_assumed_vergence(out.whole, theta), theta, slope).epipolar_px;
  }
  out.by_epipolar = judge(out.effect.epipolar_px, tolerance.epipolar_px);
  out.by_depth = depths ? judge(out.effect.depth, tolerance.depth) : HealthVerdict::kCannotTell;
  out.verdict = worst(out.by_epipolar, out.by_depth);
  for (Eigen::Index k = 0; k < (out.scale_is_lost ? 3 : 6); ++k) {  // lengths are in metres of that scale
    const auto i = static_cast<std::size_t>(k);
    if (std::isfinite(out.bands[i].ok) && !(few_depths && k == vergence_axis(theta))) {
      out.axes[i] = judge(axis_size(out.estimate, k), out.bands[i]);
    }
    out.verdict = tolerance.axes[i] ? worst(out.verdict, out.axes[i]) : out.verdict;
  }
  if (is_wrong(out.verdict)) {
    out.named = static_cast<std::size_t>(most_likely_axis(out.estimate, out.bands));
  }
}

CalibrationState with_scale(const CalibrationState& state, const TrajectoryScale& scale,
                            const RigParameters& theta, const Tolerance& tolerance) {
  BetaEstimate estimate = state.whole;
  const NormalEquations::Vector length = along_length(theta, estimate.beta);
  estimate.beta -= scale.too_long * length;
  const double variance = scale.sigma * scale.sigma - kLeastScale * kLeastScale;  // which is in there
  estimate.covariance += std::max(variance, 0.0) * length * length.transpose();
  CalibrationState out = state;
  out.verdict = out.by_epipolar = out.by_depth = HealthVerdict::kCannotTell;
  out.named.reset();
  judge_estimate(estimate, theta, true, tolerance, out);
  count_movement(out);
  return out;
}

CalibrationWatch::CalibrationWatch(const WatchOptions& options, const StereoCalibration& assumed, bool metric)
    : options_(options), theta_(assumed.theta), metric_(metric), collecting_(assumed) {
  options.tolerance.check();
  if (!(options.window_s > 0.0) || !(options.false_alarms_per_hour > 0.0)) {
    throw std::invalid_argument("health: window_s and false_alarms_per_hour must be positive");
  }
}

/// Where images alone tell how the camera moves, it trembles at rest, and depths would be told by that.
Pose CalibrationWatch::steadied(const Pose& T_world_cam0, const TrajectoryQuality& quality) {
  const bool rests = !metric_ && quality.speed_variance > 0.0 &&
                     quality.speed_squared < kSeenToMove * kSeenToMove * quality.speed_variance;
  if (rests && last_place_) trembled_ += T_world_cam0.p - *last_place_;
  last_place_ = T_world_cam0.p;
  return {T_world_cam0.R, T_world_cam0.p - trembled_};
}

void CalibrationWatch::add(const StereoFrame& frame, const Pose& T_world_cam0,
                           const TrajectoryQuality& quality) {
  if (pending_) {
    advance();
  }
  collecting_.add(frame, steadied(T_world_cam0, quality), quality.sound);
  speed_squared_ += quality.speed_squared;
  speed_variance_ += quality.speed_variance;
  const double age = seconds_between(collecting_.from_ns(), frame.t_ns);
  const bool ends = age >= options_.window_s;
  // The first window is also looked at while it grows: short recordings have no other.
  const bool looks = looks_ < kEarlyLooks.size() && age >= kEarlyLooks[looks_] * options_.window_s;
  if (!ends && !looks) {
    return;
  }
  ++looks_;
  finish();
  const double variance =
      speed_squared_ > 0.0 ? std::min(speed_variance_ / speed_squared_, kLargestScale * kLargestScale) : 0.0;
  pending_.emplace(Pending{ends ? collecting_.close() : collecting_.fit(), std::sqrt(variance), ends});
  if (ends) {
    speed_squared_ = speed_variance_ = 0.0;
    looks_ = kEarlyLooks.size();
  }
}

/// The next slice of what is being made of a window.
void CalibrationWatch::advance() {
  if (!pending_->fit.done()) {
    pending_->fit.advance();
    return;
  }
  std::optional<RigEvidence> evidence = pending_->fit.evidence();
  if (evidence) {
    evidence->scale_sigma = pending_->scale_sigma;
    const NormalEquations::Vector length = along_length(theta_, NormalEquations::Vector::Zero());
    evidence->length_weight = length.dot(evidence->all.information * length);
    if (pending_->ends) {
      end_window(*evidence);
    } else {
      auto report = std::make_shared<CalibrationReport>();
      report->state = report->window = state_of({*evidence}, theta_, metric_, options_);
      report_ = std::move(report);
    }
  }
  pending_.reset();
  if (report_to_come_) {
    report_ = std::move(*report_to_come_);
    report_to_come_.reset();
  }
}

void CalibrationWatch::finish() {
  while (pending_) {
    advance();
  }
}

std::shared_ptr<const CalibrationReport> CalibrationWatch::report_at_once() const {
  if (!pending_) {
    return report_;
  }
  if (!report_to_come_) {
    CalibrationWatch finished(*this);
    finished.finish();
    report_to_come_ = finished.report_;
  }
  return *report_to_come_;
}

std::vector<std::size_t> CalibrationWatch::changes() {
  const std::size_t n = windows_.size();
  double least = alarms_of_window(options_);
  std::vector<std::size_t> out;
  const auto consider = [&](double chance, std::vector<std::size_t> firsts) {
    if (chance < least) {
      least = chance;
      out = std::move(firsts);
    }
  };
  std::optional<ChangeWays> ways;
  std::optional<StepScatter> scatter;
  const auto steps_at = [&](const std::vector<std::size_t>& firsts) {
    std::vector<BetaEstimate> steps = robust_steps(windows_, firsts, theta_, metric_);
    if (!ways) {
      ways = ways_of_change(steps.front().epipolar, theta_, metric_, options_.tolerance);
      scatter = earlier_.along(*ways);
    }
    return steps;
  };
  std::vector<BetaEstimate> looked_at;
  for (std::size_t last = kShortestStep; last <= kLongestStep && last + 1 + kShortestStep <= n; ++last) {
    const BetaEstimate step = looked_at.emplace_back(steps_at({n - last}).front());
    if (matters(step, *ways)) {
      const Scatters scatters =
          of_windows(scatter->before(last + 1)[last - kShortestStep], step, *ways, n, 2);
      // Two windows before it may be two states: as careful as with two moments.
      const double places = n - last - 1 > kShortestStep ? 1.0 : kPlaces;
      consider(kTestsOfAWindow * places * least_chance(step, *ways, scatters), {n - last});
    }
    for (std::size_t middle = kShortestStep; middle <= kLongestStep && last + middle + 3 <= n; ++middle) {
      const std::vector<BetaEstimate> steps = steps_at({n - last - 1 - middle, n - last});
      if (!matters(steps.front(), *ways) || !matters(steps.back(), *ways)) {
        continue;  // one state less would do
      }
      const ScattersByLength& scatters = scatter->before(last + middle + 2);
      const Scatters of_middle = of_windows(scatters[middle - kShortestStep], steps.front(), *ways, n, 3);
      const Scatters of_last = of_windows(scatters[last - kShortestStep], steps.back(), *ways, n, 3);
      constexpr double kTests = kTestsOfAWindow * kPlaces;
      if (kTests * least_chance(steps.front(), *ways, of_middle) < kDoubt) {
        consider(kTests * least_chance(steps.back(), *ways, worse(of_middle, of_last)),
                 {n - last - 1 - middle, n - last});
      }
    }
  }
  earlier_.begin_window();
  for (std::size_t k = 0; k < looked_at.size(); ++k) {
    earlier_.add(kShortestStep + k, looked_at[k]);
  }
  const bool drifts =
      !out.empty() && line_through(windows_, theta_, metric_, options_.tolerance).chance < least;
  return drifts ? std::vector<std::size_t>{} : out;
}

void CalibrationWatch::end_window(const RigEvidence& evidence) {
  bool drifts = report_ && report_->state.drift;
  const auto judged = [&](const std::vector<RigEvidence>& windows) {
    return state_of(windows, theta_, metric_, options_, std::min(chosen_, windows.size()), drifts);
  };
  auto report = std::make_shared<CalibrationReport>();
  report->window = judged({evidence});
  if (report->window.scale_is_lost) {  // or others would share its length
    report->state = report->window;
    report_ = std::move(report);
    return;
  }
  append(evidence, windows_);
  std::size_t from = 0;
  for (const std::size_t first : changes()) {
    report->past.push_back(judged({windows_.begin() + static_cast<std::ptrdiff_t>(from),
                                   windows_.begin() + static_cast<std::ptrdiff_t>(first) - 1}));
    from = first;
    chosen_ = windows_.size() - first;
    drifts = false;  // of the state before
  }
  windows_.erase(windows_.begin(), windows_.begin() + static_cast<std::ptrdiff_t>(from));
  if (windows_.size() > kMostWindows) {
    halve(windows_);
    chosen_ = (chosen_ + 1) / 2;
  }
  report->state = judged(windows_);
  report_ = std::move(report);
}

}  // namespace limber
