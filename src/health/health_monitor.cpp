// SPDX-License-Identifier: MIT
#include "limber/health/health_monitor.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "limber/core/chi_square.hpp"
#include "limber/method.hpp"

namespace limber {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// What delta may be at most [plausible errors, one standard deviation]: 1 deg, 50 % of the baseline.
constexpr double kWidest = 10.0;
/// A direction known worse than that says nothing.
constexpr double kWeakest = 1.0 / (kWidest * kWidest);
/// The noise of the other rows is believed as if one had seen this many of them with the stated noise.
constexpr double kNoisePrior = 500.0;
/// An axis is named where it is that many standard deviations off, in the frame of the alarm ...
constexpr double kNamedAtOnce = 3.5;
/// ... and later, while evidence gathers and many frames are looked at.
constexpr double kNamedLater = 4.5;
constexpr double kSuspectFactor = 20.0;    // suspect where an alarm's p-value is that near
constexpr double kRecovered = 0.01;        // p-value of a window that ends an alarm
constexpr double kLongestFrame = 1.0;      // [s], a longer gap has no more chances of a false alarm
/// When a window is looked at, as shares of its length.
constexpr std::array<double, 5> kLooks = {1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 1.0};
constexpr double kNanoseconds = 1e-9;

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return kNanoseconds * static_cast<double>(to_ns - from_ns);
}

void check(double value, const char* name) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw std::invalid_argument("health: " + std::string(name) + " is " + std::to_string(value) +
                                ", expected a positive number");
  }
}

}  // namespace

std::string to_string(HealthVerdict verdict) {
  switch (verdict) {
    case HealthVerdict::kOk:
      return "ok";
    case HealthVerdict::kSuspect:
      return "suspect";
    case HealthVerdict::kDecalibrated:
      return "decalibrated";
    case HealthVerdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

HealthMonitor::HealthMonitor(const HealthOptions& options, double baseline)
    : options_(options), scale_(plausible_error(baseline)) {
  check(options.false_alarms_per_hour, "false_alarms_per_hour");
  check(options.window_s, "window_s");
  check(options.resolution, "resolution");
  sigma_of_window_.setConstant(std::numeric_limits<double>::infinity());
}

double HealthMonitor::noise() const { return (nis_ + kNoisePrior) / (dof_ + kNoisePrior); }

double HealthMonitor::p_value(const ParameterEvidence& evidence) const {
  const EvidenceStatistic s = statistic(evidence, kWeakest);
  return s.dof == 0 ? 1.0 : chi_square_survival(s.value / noise(), static_cast<double>(s.dof));
}

HealthMonitor::Offset HealthMonitor::offset(const ParameterEvidence& evidence,
                                            const MatrixXd& directions) const {
  Offset out{RigParameters::Zero(), kWidest * scale_};
  if (evidence.empty()) {
    return out;
  }
  MatrixXd A = evidence.information / noise();
  A.diagonal().array() += kWeakest;
  const MatrixXd covariance = A.llt().solve(MatrixXd::Identity(A.rows(), A.cols()));
  out.delta = directions * (covariance * evidence.vector) / noise();
  out.sigma = (directions * covariance * directions.transpose()).diagonal().cwiseSqrt();
  // What no direction touches (the length of the baseline, say) stays unknown.
  const MatrixXd B = scale_.cwiseInverse().asDiagonal() * directions;
  const MatrixXd unseen = MatrixXd::Identity(6, 6) - B * B.completeOrthogonalDecomposition().pseudoInverse();
  out.sigma += kWidest * scale_.cwiseProduct(unseen.rowwise().norm());
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

/// The tests: each frame, and each window as it ends.
bool HealthMonitor::test(const HealthInput& input, double frame_p, double window_p, const Offset& frame,
                         const Offset& gathered) {
  const double hours = std::min(seconds(last_ns_, input.t_ns), kLongestFrame) / 3600.0;
  const double share = 0.5 * options_.false_alarms_per_hour;
  const double frame_limit = started_ ? share * hours : 0.0;
  const double window_limit = share * options_.window_s / 3600.0 / static_cast<double>(kLooks.size());
  const double age = seconds(gathered_since_ns_, input.t_ns);
  const bool looks = looks_ < kLooks.size() && age >= kLooks[looks_] * options_.window_s;
  looks_ += looks ? 1 : 0;
  const bool ends = age >= options_.window_s;
  const bool frame_rejects = frame_p < frame_limit;
  const bool window_rejects = looks && window_p < window_limit;
  suspect_ = frame_p < kSuspectFactor * frame_limit || window_p < kSuspectFactor * window_limit;
  const bool is_new = !changed_ns_ && (frame_rejects || window_rejects);
  if (is_new) {
    changed_ns_ = frame_rejects ? input.t_ns : gathered_since_ns_;
    name_axes(frame_rejects ? frame : gathered, kNamedAtOnce);
  } else if (changed_ns_ && window_p < window_limit) {
    name_axes(gathered, kNamedLater);
  } else if (ends && window_p > kRecovered) {
    changed_ns_.reset();
    named_ = {};
  }
  if (ends) {
    sigma_of_window_ = gathered.sigma;
  }
  restarts_ = ends || is_new;  // from here on evidence of the new rig gathers
  return frame_rejects || window_rejects;
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
  gather(input);
  const Offset frame = offset(input.frame, input.directions);
  const Offset gathered = offset(gathered_, input.directions);
  HealthReport report;
  report.t_ns = input.t_ns;
  report.p_value = p_value(input.frame);
  report.gathered_p_value = p_value(gathered_);
  report.gathered_since_ns = gathered_since_ns_;
  report.alarm = test(input, report.p_value, report.gathered_p_value, frame, gathered);
  report.delta = frame.delta;
  report.sigma = frame.sigma;
  report.gathered_delta = gathered.delta;
  report.gathered_sigma = gathered.sigma;
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
