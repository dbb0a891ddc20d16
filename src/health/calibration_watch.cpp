// SPDX-License-Identifier: MIT
#include "limber/health/calibration_watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"

namespace limber {

namespace {

constexpr std::size_t kMostWindows = 400;               // that are kept; then neighbours are merged
constexpr std::size_t kFewestNew = 2;                   // windows that a state has to last to be one
constexpr std::size_t kMostNew = 5;                     // within which it is seen, if it is
constexpr double kLengths = kMostNew - kFewestNew + 1;  // that are tried
constexpr double kRelevant = 0.5;                       // share of what is ok
constexpr int kMainWays = 4;                            // to leave the epipolar lines
constexpr double kTests = 2.0;                          // after a window: for changes, for a drift
constexpr std::size_t kFewestOfADrift = 5;              // windows
constexpr double kDoubt = 0.01;                         // p-value of a drift that is reckoned with
constexpr std::array kEarlyLooks = {0.2, 0.4, 0.7};     // at the first window, as shares of its length
constexpr double kLargestScale = 0.5;  // relative error of a metre: no sensor is believed to be worse

void merge(const RigEvidence& other, RigEvidence& into) {
  into.to_ns = other.to_ns;
  into.all += other.all;
  for (const auto& [cell, sums] : other.cells) {
    into.cells[cell] += sums;
  }
  into.tracks += other.tracks;
  into.both += other.both;
  into.epipolar += other.epipolar;
  into.points += other.points;
  into.track_count += other.track_count;
  into.deep += other.deep;
  into.deep_tracks += other.deep_tracks;
  into.scale_sigma = std::max(into.scale_sigma, other.scale_sigma);
  for (std::size_t k = 0; k < into.blocks.size() && k < other.blocks.size(); ++k) {
    into.blocks[k] += other.blocks[k];
  }
  for (std::size_t k = 0; k < into.depth_blocks.size() && k < other.depth_blocks.size(); ++k) {
    into.depth_blocks[k] += other.depth_blocks[k];
  }
}

void halve(std::vector<RigEvidence>& windows) {
  std::vector<RigEvidence> out;
  for (std::size_t k = 0; k < windows.size(); k += 2) {
    out.push_back(windows[k]);
    if (k + 1 < windows.size()) {
      merge(windows[k + 1], out.back());
    }
  }
  windows = std::move(out);
}

}  // namespace

namespace {

/// Without a sensor that knows a metre the length of the baseline is trusted.
RigParameters visible_slope(const RigParameters& theta, bool metric, const Tolerance& tolerance) {
  RigParameters slope = depth_slope(theta, tolerance.baselines);
  if (!metric) {
    const Eigen::Vector3d along = theta.tail<3>().normalized();
    slope.tail<3>() -= along * along.dot(slope.tail<3>());
  }
  return slope;
}

RigParameters px_by_axis(const BetaEstimate& estimate, const RigParameters& theta) {
  const NormalEquations::Vector px = estimate.epipolar.diagonal().cwiseMax(0.0).cwiseSqrt();
  return px.head<6>().cwiseQuotient(plausible_error(theta.tail<3>().norm()));
}

/// Two-sided p-value of Student's t: Wallace's approximation.
double t_survival(double t, double dof) {
  const double z2 = dof * std::log1p(t * t / dof);
  const double factor = (8.0 * dof + 1.0) / (8.0 * dof + 3.0);
  return chi_square_survival(factor * factor * z2, 1.0);
}

void judge_movement(const std::vector<RigEvidence>& windows, const RigParameters& theta,
                    const Tolerance& tolerance, CalibrationState& out) {
  std::vector<FrameHalves> blocks;
  std::vector<DepthHalves> depth_blocks;
  for (const RigEvidence& window : windows) {
    blocks.insert(blocks.end(), window.blocks.begin(), window.blocks.end());
    depth_blocks.insert(depth_blocks.end(), window.depth_blocks.begin(), window.depth_blocks.end());
  }
  out.movement = movement_of(blocks, out.whole.epipolar);
  out.depth_movement = depth_movement_of(depth_blocks, theta, tolerance.baselines);
  out.by_movement = judge(out.movement.px, tolerance.epipolar_px);
  out.by_depth_movement = out.deep_tracks < kFewestTracks ? HealthVerdict::kCannotTell
                                                          : judge(out.depth_movement.share, tolerance.depth);
  if (out.tracks < kFewestTracks) {
    return;
  }
  out.verdict = worst(out.verdict, worst(out.by_movement, out.by_depth_movement));
  if (!out.named && out.moves()) {
    out.named = out.moving_axis();
  }
}

/// p-value below which a test after a window has found something.
double alarm_limit(const WatchOptions& options) {
  return options.false_alarms_per_hour * options.window_s / 3600.0 / kTests;
}

/// The p-value of what is relevant, in depth or in one of the main ways to leave the epipolar lines: the
/// least one, times their number. Infinite where nothing is.
double chance_of(const BetaEstimate& step, double dof, const RigParameters& theta, bool metric,
                 const Tolerance& tolerance) {
  double least = std::numeric_limits<double>::infinity();
  const auto look_at = [&](double value, double variance) {
    least = std::min(least, t_survival(value / std::sqrt(std::max(variance, 1e-30)), dof));
  };
  const CalibrationEffect effect = effect_of(step, theta, visible_slope(theta, metric, tolerance));
  const double depth_sigma = (effect.depth.high - effect.depth.size) / 1.96;
  if (effect.depth.size > kRelevant * tolerance.depth.ok) {
    look_at(effect.depth.size, depth_sigma * depth_sigma);
  }
  const SymmetricEigen ways = symmetric_eigen(step.epipolar);
  for (Eigen::Index k = 0; k < kMainWays; ++k) {
    const NormalEquations::Vector way = ways.vectors.col(NormalEquations::kSize - 1 - k);
    const double px = std::sqrt(std::max(ways.values(NormalEquations::kSize - 1 - k), 0.0));
    const double size = way.dot(step.beta);
    if (px * std::abs(size) > kRelevant * tolerance.epipolar_px.ok) {
      look_at(size, way.dot(step.covariance * way));
    }
  }
  return (1.0 + kMainWays) * least;
}

/// Of a drift that is not relevant: anything up to that, uniformly, in depth and on the epipolar lines.
NormalEquations::Matrix drift_not_looked_for(NormalEquations::Matrix epipolar, const RigParameters& theta,
                                             bool metric, const Tolerance& tolerance) {
  constexpr auto kVergence = NormalEquations::kVergence, kLens = NormalEquations::kLens;
  // On the lines vergence is taken for what a lens does: that drifts with it.
  epipolar(kLens, kLens) = epipolar(kVergence, kVergence);
  NormalEquations::Vector depth = NormalEquations::Vector::Zero();
  depth.head<6>() =
      visible_slope(theta, metric, tolerance).cwiseProduct(plausible_error(theta.tail<3>().norm()));
  const auto variance = [](double ok) { return kRelevant * kRelevant * ok * ok / 3.0; };
  const NormalEquations::Matrix information = epipolar / variance(tolerance.epipolar_px.ok) +
                                              depth * depth.transpose() / variance(tolerance.depth.ok) +
                                              NormalEquations::kPrior * NormalEquations::Matrix::Identity();
  return Cholesky(information).inverse();
}

/// The error at the end of windows that are enough for a line.
/// @param drift  set where there is one
BetaEstimate estimate_at_end(const std::vector<RigEvidence>& windows, const RigParameters& theta, bool metric,
                             const WatchOptions& options, std::optional<RigDrift>& drift) {
  const BetaTrend trend = robust_trend(windows, theta, metric);
  const double chance =
      chance_of(trend.change, static_cast<double>(windows.size()) - 1.0, theta, metric, options.tolerance);
  if (chance < alarm_limit(options)) {
    drift = RigDrift{trend.change.rig(theta), trend.seconds, 0};
  }
  return chance < kDoubt ? trend.now
                         : with_drift_within(trend, drift_not_looked_for(trend.change.epipolar, theta, metric,
                                                                         options.tolerance));
}

}  // namespace

bool CalibrationState::moves() const { return is_wrong(by_movement) || is_wrong(by_depth_movement); }

std::size_t CalibrationState::moving_axis() const {
  const Eigen::Index axis = is_wrong(by_movement) ? movement.axis : depth_movement.axis;
  return static_cast<std::size_t>(axis);
}

CalibrationState state_of(const std::vector<RigEvidence>& windows, const RigParameters& theta, bool metric,
                          const WatchOptions& options) {
  CalibrationState out;
  out.from_ns = windows.front().from_ns;
  out.to_ns = windows.back().to_ns;
  out.windows = windows.size();
  for (const RigEvidence& window : windows) {
    out.points += window.points;
    out.tracks += window.track_count;
    out.deep += window.deep;
    out.deep_tracks += window.deep_tracks;
  }
  const BetaEstimate estimate = windows.size() < kFewestOfADrift
                                    ? robust_estimate(windows, theta, metric)
                                    : estimate_at_end(windows, theta, metric, options, out.drift);
  judge_estimate(estimate, theta, metric, options.tolerance, out);
  if (out.drift) {
    out.drift->named = static_cast<std::size_t>(most_likely_axis(out.drift->change, out.bands));
  }
  judge_movement(windows, theta, options.tolerance, out);
  return out;
}

void judge_estimate(const BetaEstimate& estimate, const RigParameters& theta, bool metric,
                    const Tolerance& tolerance, CalibrationState& out) {
  const RigParameters slope = visible_slope(theta, metric, tolerance);
  out.whole = estimate;
  out.estimate = estimate.rig(theta);
  out.effect = effect_of(estimate, theta, slope);
  out.bands = axis_bands(tolerance, px_by_axis(estimate, theta), slope);
  out.axes.fill(HealthVerdict::kCannotTell);
  if (out.tracks < kFewestTracks) {
    return;
  }
  for (Eigen::Index k = 0; k < 6; ++k) {
    const auto i = static_cast<std::size_t>(k);
    out.axes[i] = judge(axis_size(out.estimate, k), out.bands[i]);
  }
  out.by_epipolar = judge(out.effect.epipolar_px, tolerance.epipolar_px);
  out.by_depth =
      out.deep_tracks < kFewestTracks ? HealthVerdict::kCannotTell : judge(out.effect.depth, tolerance.depth);
  out.verdict = worst(out.by_epipolar, out.by_depth);
  for (std::size_t k = 0; k < 6; ++k) {
    out.verdict = tolerance.axes[k] ? worst(out.verdict, out.axes[k]) : out.verdict;
  }
  if (is_wrong(out.verdict)) {
    out.named = static_cast<std::size_t>(most_likely_axis(out.estimate, out.bands));
  }
}

CalibrationWatch::CalibrationWatch(const WatchOptions& options, const StereoCalibration& assumed, bool metric)
    : options_(options), theta_(assumed.theta), metric_(metric), collecting_(assumed) {
  options.tolerance.check();
  if (!(options.window_s > 0.0) || !(options.false_alarms_per_hour > 0.0)) {
    throw std::invalid_argument("health: window_s and false_alarms_per_hour must be positive");
  }
}

void CalibrationWatch::add(const StereoFrame& frame, const Pose& T_world_cam0,
                           const TrajectoryQuality& quality) {
  if (pending_) {
    advance();
  }
  collecting_.add(frame, T_world_cam0, quality.sound);
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

std::vector<std::size_t> CalibrationWatch::changes() const {
  const std::size_t n = windows_.size();
  double least = alarm_limit(options_);
  std::vector<std::size_t> out;
  const auto consider = [&](const std::vector<std::size_t>& firsts, double looks) {
    // The windows that are left, without a state each; and two that the expected scatter is worth.
    const double dof = static_cast<double>(n + 1 - 2 * firsts.size());
    const auto steps = robust_steps(windows_, firsts, theta_, metric_);
    const auto chance_at = [&](const BetaEstimate& step) {
      return looks * chance_of(step, dof, theta_, metric_, options_.tolerance);
    };
    if (chance_at(steps.front()) > kDoubt) {
      return;  // one state less would do
    }
    const double chance = chance_at(steps.back());
    if (chance < least) {
      least = chance;
      out = firsts;
    }
  };
  for (std::size_t last = kFewestNew; last <= kMostNew && last + 1 + kFewestNew <= n; ++last) {
    consider({n - last}, 2.0 * kLengths);
    for (std::size_t middle = kFewestNew; middle <= kMostNew && last + middle + 3 <= n; ++middle) {
      consider({n - last - 1 - middle, n - last}, 2.0 * kLengths * kLengths);
    }
  }
  if (!out.empty() && chance_of(robust_trend(windows_, theta_, metric_).change, static_cast<double>(n) - 1.0,
                                theta_, metric_, options_.tolerance) < least) {
    return {};
  }
  return out;
}

void CalibrationWatch::end_window(const RigEvidence& evidence) {
  const auto judged = [&](const std::vector<RigEvidence>& windows) {
    return state_of(windows, theta_, metric_, options_);
  };
  auto report = std::make_shared<CalibrationReport>();
  report->window = judged({evidence});
  windows_.push_back(evidence);
  std::size_t from = 0;
  for (const std::size_t first : changes()) {
    report->past.push_back(judged({windows_.begin() + static_cast<std::ptrdiff_t>(from),
                                   windows_.begin() + static_cast<std::ptrdiff_t>(first) - 1}));
    from = first;
  }
  windows_.erase(windows_.begin(), windows_.begin() + static_cast<std::ptrdiff_t>(from));
  if (windows_.size() > kMostWindows) {
    halve(windows_);
  }
  report->state = judged(windows_);
  report_ = std::move(report);
}

}  // namespace limber
