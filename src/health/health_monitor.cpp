// SPDX-License-Identifier: MIT
#include "limber/health/health_monitor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "limber/core/chi_square.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"
#include "limber/sensors/calibration.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A direction known worse than that says nothing.
constexpr double kWeakest = 1.0 / (kWidestErrors * kWidestErrors);
/// The noise of the other rows is believed as if one had seen this many of them with the stated noise.
constexpr double kNoisePrior = 500.0;
/// An axis is named where it is that many standard deviations off, in the frame of the alarm ...
constexpr double kNamedAtOnce = 3.5;
/// ... and later, while evidence gathers and many frames are looked at.
constexpr double kNamedLater = 4.5;
constexpr double kSuspectFactor = 20.0;        // suspect where an alarm's p-value is that near
constexpr double kRecovered = 0.01;            // p-value of a window that ends an alarm
constexpr double kConfirms = 0.01;             // p-value of a frame that says what the one before did
constexpr double kLongestFrame = 1.0;          // [s], a longer gap has no more chances of a false alarm
constexpr double kFirstFrame = 0.01;           // [s], taken for the time since a frame that was not
constexpr double kKeptPerWindow = 0.9;         // of what earlier windows said about scatter
constexpr double kRemembered = 0.98;           // of the largest scatter of a window, per window
constexpr double kLuckyScatter = 1.25;         // the largest of many windows of white frames
constexpr std::size_t kFewestOfAScatter = 10;  // of a window that has a scatter
constexpr double kWhiteEnough = 0.2;           // correlation of neighbours that pose and map may cause
constexpr double kMostCorrelated = 0.95;
/// When a window is looked at, as shares of its length.
constexpr std::array<double, 5> kLooks = {1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 1.0};

void check(double value, const char* name) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw std::invalid_argument("health: " + std::string(name) + " is " + std::to_string(value) +
                                ", expected a positive number");
  }
}

}  // namespace

HealthMonitor::HealthMonitor(const HealthOptions& options, double baseline)
    : options_(options), scale_(plausible_error(baseline)) {
  check(options.false_alarms_per_hour, "false_alarms_per_hour");
  check(options.window_s, "window_s");
  check(options.resolution, "resolution");
  check(options.most_dispersion, "most_dispersion");
  sigma_of_window_.setConstant(std::numeric_limits<double>::infinity());
}

/// Never less than was stated: rows that fit too well say nothing for the others.
double HealthMonitor::noise() const { return std::max((nis_ + kNoisePrior) / (dof_ + kNoisePrior), 1.0); }

/// The window is over: how its frames deviated from their mean.
void HealthMonitor::scatter(const ParameterEvidence& frame) {
  if (restarts_) {
    VectorXd mean = VectorXd::Zero(whitened_.empty() ? 0 : whitened_.front().size());
    const auto n = static_cast<double>(whitened_.size());
    for (const VectorXd& u : whitened_) {
      mean += u / n;
    }
    double squares = 0.0, numbers = 0.0;
    squares_ *= kKeptPerWindow;
    products_ *= kKeptPerWindow;
    for (std::size_t k = 0; k < whitened_.size() && whitened_.size() >= kFewestOfAScatter; ++k) {
      squares += (whitened_[k] - mean).squaredNorm() * n / (n - 1.0);
      numbers += static_cast<double>(mean.size());
      products_ += k > 0 ? (whitened_[k] - mean).dot(whitened_[k - 1] - mean) : 0.0;
    }
    squares_ += squares;
    if (numbers > 0.0) {
      largest_scatter_ = std::max(kRemembered * largest_scatter_.value_or(0.0), squares / numbers);
    }
    whitened_.clear();
  }
  const Cholesky llt(frame.information);
  if (!frame.empty() && llt.succeeded() &&
      (whitened_.empty() || whitened_.front().size() == frame.vector.size())) {
    solve_lower(llt.factor(), whitened_.emplace_back(frame.vector));
  }
}

/// Of frames; as large as is allowed while nothing is known.
double HealthMonitor::dispersion() const {
  const double measured =
      largest_scatter_ ? *largest_scatter_ / (kLuckyScatter * noise()) : options_.most_dispersion;
  return std::clamp(measured, 1.0, options_.most_dispersion);
}

/// Of a window's sum: neighbours that lean to the same side count as fewer (first-order autoregression).
double HealthMonitor::dispersion_of_window() const {
  if (options_.most_dispersion <= 1.0 || !(squares_ > 0.0)) {
    return dispersion();
  }
  const double correlation =
      std::clamp((products_ / squares_ - kWhiteEnough) / (1.0 - kWhiteEnough), 0.0, kMostCorrelated);
  return dispersion() * (1.0 + correlation) / (1.0 - correlation);
}

double HealthMonitor::p_value(const ParameterEvidence& evidence, double dispersion) const {
  const EvidenceStatistic s = statistic(evidence, kWeakest);
  return s.dof == 0 ? 1.0 : chi_square_survival(s.value / (noise() * dispersion), static_cast<double>(s.dof));
}

HealthMonitor::Offset HealthMonitor::offset(const ParameterEvidence& evidence, const MatrixXd& directions,
                                            double dispersion) const {
  Offset out{RigParameters::Zero(), kWidestErrors * scale_};
  if (evidence.empty()) {
    return out;
  }
  const double variance = noise() * dispersion;
  MatrixXd A = evidence.information / variance;
  A.diagonal().array() += kWeakest;
  const MatrixXd covariance = Cholesky(A).inverse();
  out.delta = directions * (covariance * evidence.vector) / variance;
  out.sigma = congruence(directions, covariance).diagonal().cwiseSqrt();
  // What no direction touches (the length of the baseline, say) stays unknown.
  const MatrixXd B = scale_.cwiseInverse().asDiagonal() * directions;
  const MatrixXd unseen = MatrixXd::Identity(6, 6) - multiply(B, pseudo_inverse(B));
  out.sigma += kWidestErrors * scale_.cwiseProduct(unseen.rowwise().norm());
  return out;
}

void HealthMonitor::gather(const HealthInput& input) {
  if (restarts_ || !started_) {
    gathered_ = {};
    looks_ = 0;
    gathered_since_ns_ = started_ ? last_ns_ : input.t_ns;
  }
  restarts_ = false;
  if (input.gathered) {
    gathered_ = *input.gathered;
  } else if (gathered_.empty()) {
    gathered_ = input.frame;
  } else if (!input.frame.empty()) {
    gathered_.information += input.frame.information;
    gathered_.vector += input.frame.vector;
  }
}

void HealthMonitor::name_axes(const Offset& offset, double threshold) {
  const RigParameters ratio = offset.delta.cwiseAbs().cwiseQuotient(offset.sigma);
  Index largest = 0;
  ratio.maxCoeff(&largest);
  for (Index k = 0; k < 6; ++k) {
    named_[static_cast<std::size_t>(k)] = ratio(k) > threshold || k == largest;
  }
}

/// A frame alone, or with the one after it that says so, too: then `report` is that of the first of them,
/// since the second one is seen from a state that the first has moved. One that sees nothing says nothing.
bool HealthMonitor::frame_rejects(const HealthInput& input, double limit, HealthReport& report) {
  if (!options_.confirm_frames) {
    return report.p_value < limit;
  }
  if (input.frame.empty()) {
    return false;
  }
  const std::optional<HealthReport> before = std::exchange(unconfirmed_, std::nullopt);
  if (before && report.p_value < kConfirms) {
    report.delta = before->delta;
    report.sigma = before->sigma;
    report.p_value = before->p_value;
    return true;
  }
  if (report.p_value < limit) {
    unconfirmed_ = report;
  }
  return false;
}

/// The tests: each frame, and each window as it ends.
void HealthMonitor::test(const HealthInput& input, const Offset& frame, const Offset& gathered,
                         HealthReport& report) {
  const double seconds = started_ ? seconds_between(last_ns_, input.t_ns) : kFirstFrame;
  const double hours = std::min(seconds, kLongestFrame) / 3600.0;
  const double share = 0.5 * options_.false_alarms_per_hour;
  const double frame_limit = share * hours;
  const double window_limit = share * options_.window_s / 3600.0 / static_cast<double>(kLooks.size());
  const double age = seconds_between(gathered_since_ns_, input.t_ns);
  const double window_p = report.gathered_p_value;
  const std::int64_t since_ns = unconfirmed_ ? unconfirmed_->t_ns : input.t_ns;
  const bool before_unconfirmed = is_unconfirmed();
  const bool rejects = frame_rejects(input, frame_limit, report);
  const bool forgets = before_unconfirmed && !rejects && !is_unconfirmed();
  const bool looks =
      !is_unconfirmed() && !forgets && looks_ < kLooks.size() && age >= kLooks[looks_] * options_.window_s;
  looks_ += looks ? 1 : 0;
  const bool ends = age >= options_.window_s;
  const bool window_rejects = looks && window_p < window_limit;
  suspect_ = report.p_value < kSuspectFactor * frame_limit || window_p < kSuspectFactor * window_limit;
  const bool is_new = !changed_ns_ && (rejects || window_rejects);
  if (is_new) {
    changed_ns_ = rejects ? since_ns : gathered_since_ns_;
    name_axes(rejects ? frame : gathered, kNamedAtOnce);
  } else if (changed_ns_ && window_p < window_limit) {
    name_axes(gathered, kNamedLater);
  } else if (ends && window_p > kRecovered) {
    changed_ns_.reset();
    named_ = {};
  }
  if (ends) {
    sigma_of_window_ = gathered.sigma;
  }
  restarts_ = ends || is_new || forgets;  // from here on evidence of the new rig gathers
  report.alarm = rejects || window_rejects;
}

HealthVerdict HealthMonitor::verdict_of_axis(Index axis, const RigParameters& sigma) const {
  if (changed_ns_ && named_[static_cast<std::size_t>(axis)]) {
    return HealthVerdict::kDecalibrated;
  }
  const double known = std::min(sigma(axis), sigma_of_window_(axis));
  return known > options_.resolution * scale_(axis) ? HealthVerdict::kCannotTell : HealthVerdict::kOk;
}

HealthVerdict HealthMonitor::verdict(const HealthReport& report) const {
  if (changed_ns_) {
    return HealthVerdict::kDecalibrated;
  }
  if (suspect_) {
    return HealthVerdict::kSuspect;
  }
  const bool blind = std::all_of(report.axes.begin(), report.axes.end(),
                                 [](HealthVerdict axis) { return axis == HealthVerdict::kCannotTell; });
  return blind ? HealthVerdict::kCannotTell : HealthVerdict::kOk;
}

HealthReport HealthMonitor::judge(const HealthInput& input) {
  nis_ += input.nis;
  dof_ += input.dof;
  scatter(input.frame);
  gather(input);
  const Offset frame = offset(input.frame, input.directions, dispersion());
  const Offset gathered = offset(gathered_, input.directions, dispersion_of_window());
  HealthReport report;
  report.t_ns = input.t_ns;
  report.p_value = p_value(input.frame, dispersion());
  report.gathered_p_value = p_value(gathered_, dispersion_of_window());
  report.gathered_since_ns = gathered_since_ns_;
  report.delta = frame.delta;
  report.sigma = frame.sigma;
  report.gathered_delta = gathered.delta;
  report.gathered_sigma = gathered.sigma;
  test(input, frame, gathered, report);
  for (Index k = 0; k < 6; ++k) {
    report.axes[static_cast<std::size_t>(k)] = verdict_of_axis(k, gathered.sigma);
  }
  report.verdict = verdict(report);
  report.changed_ns = changed_ns_;
  last_ns_ = input.t_ns;
  started_ = true;
  return report;
}

}  // namespace limber
