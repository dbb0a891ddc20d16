// SPDX-License-Identifier: MIT
// What a start's solution knows, and whether images and inputs still agree upon it.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "hand_over.hpp"
#include "rig_offset.hpp"
#include "start_window.hpp"
#include "window_pixels.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using L = StateLayout;

namespace {

/// Misfit over the least of all solutions, of one that contradicts it.
constexpr double kDisagrees = 3.0;
constexpr double kLeastAtRest = 0.1;   // of the misfits that later ones are compared to
constexpr double kFitsAsWell = 1.1;    // of a rig that is trusted, which has fewer unknowns
constexpr double kFitsTheSame = 1.05;  // where it gives the scale; 0.1 deg of vergence pass, 0.3 do not
constexpr double kFitsMuchBetter = 0.9;
constexpr double kRefines = 0.9;  // of the scale's sigma, from one solution to the next
constexpr double kTrend = 1.2;    // of the window's length

/// Directions of theta that leave disparities as they are: neither vergence nor the length of the baseline.
std::vector<Index> across_disparities(const WindowModel& model) {
  constexpr double kAcross = 0.1;  // cosine
  const Eigen::Vector3d along = model.calibration.theta.tail<3>().normalized();
  std::vector<Index> out;
  for (Index k = 0; k < model.directions.cols(); ++k) {
    const Eigen::Matrix<double, 6, 1> of = model.directions.col(k);
    if (of(1) == 0.0 && std::abs(along.dot(of.tail<3>())) <= kAcross * of.tail<3>().norm()) {
      out.push_back(k);
    }
  }
  return out;
}

}  // namespace

double StartWindow::tilt_sigma() const {
  if (model.options.motion != MotionModel::kImu) {
    return 0.0;
  }
  const Index last = static_cast<Index>(solution->frames.size() - 1) * model.frame_size() + L::kAttitude;
  const Matrix3d& R = solution->frames.back().nav.T_world_body.R;
  const Matrix3d P = R * covariance.block<3, 3>(last, last) * R.transpose();
  return std::sqrt(std::max(P(0, 0), P(1, 1)));
}

/// Of the logarithm of what all inverse depths have in common.
double StartWindow::scale_sigma() const {
  const double stated = scale_information(model, *solution, normal, covariance);
  const double information = leaves_scale_open() ? without_noise(stated) : stated;
  return information > 0.0 ? 1.0 / std::sqrt(information) : kUnknown;
}

/// What the solution knows of what was asked for.
StartReport StartWindow::judged() const {
  StartReport out;
  out.waited_s = waited_s();
  out.tilt_sigma = solution ? tilt_sigma() : kUnknown;
  out.scale_sigma = solution ? scale_sigma() : kUnknown;
  const double cheap = model.prior.bias_accel / WindowPrior{}.bias_accel;
  const bool tilt = out.tilt_sigma <= cheap * options.tilt_sigma;  // at rest it tells no better
  const bool scale =
      out.scale_sigma <= (leaves_scale_open() ? options.open_scale_sigma : options.scale_sigma);
  const bool settled = !solution || normal.left <= kSettled;
  if (!solution) {
    out.missing = "a motion that images and inputs agree upon";
  } else if (!scale) {
    out.missing =
        moves() ? "no acceleration yet that tells the scale" : "no parallax yet that tells the scale";
  } else if (!settled && tilt) {
    out.missing = "a solution that has settled";
  }
  if (solution && !tilt) {
    out.missing += std::string(out.missing.empty() ? "" : "; ") +
                   "no turn or acceleration yet that tells the tilt from a bias";
  }
  const bool waits_for_motion = !scale && (moves() ? has_scale(model.options.motion) : awaits_motion());
  const double longest_s = !waits_for_motion ? options.longest_s
                           : moves()         ? options.longest_moving_s
                                             : kUnknown;
  const bool is_over = length() >= longest_s || is_out_of_time();
  out.status = tilt && scale && settled ? StartStatus::kReady
               : is_over                ? StartStatus::kTimedOut
                                        : StartStatus::kWaiting;
  return out;
}

/// A start that may be used is worth more a little later. A window that has hardly grown tells no trend.
bool StartWindow::still_refines(const StartReport& now, double scale_before, double solved_before_s) const {
  const bool improves = now.scale_sigma < kRefines * scale_before || length() < kTrend * solved_before_s;
  return now.status == StartStatus::kReady && is_over_by_motion() && length() < options.longest_fine_s &&
         !is_out_of_time() && now.scale_sigma > options.fine_scale_sigma && improves;
}

StartReport StartWindow::solve_and_judge() {
  const double solved_before_s = solved_s;
  double scale_before = report.scale_sigma;
  solve();
  StartReport out = judged();
  bool failed = disagrees();
  const Asked asked = failed || out.status != StartStatus::kWaiting ? Asked::kAtTheEnd : Asked::kMeanwhile;
  if ((asked == Asked::kAtTheEnd || !knows_clock()) && learn_clock_or_step(asked)) {
    out = judged();
    failed = disagrees();
  }
  if ((failed || out.status != StartStatus::kWaiting) && explain_by_step()) {
    out = judged();
    failed = disagrees();
  }
  // One solution alone may be stuck; the next one, with more frames, mostly is not.
  const bool again = std::exchange(failed_before, failed);
  failed = failed && (again || out.status != StartStatus::kWaiting);
  if (failed && explain_by_clock()) {
    out = judged();
    failed = disagrees();
  }
  if (!failed && learn_accel_bias()) {
    out = judged();
  }
  if (!failed && out.status != StartStatus::kWaiting && learn_imu_noise()) {
    out = judged();
    scale_before = kUnknown;  // of another noise
  }
  if (failed) {
    go_back();
    out = judged();
    out.status = StartStatus::kTimedOut;
    out.missing +=
        std::string(out.missing.empty() ? "" : "; ") + "what happened then: images and inputs agree no more";
  } else if (still_refines(out, scale_before, solved_before_s)) {
    out.status = StartStatus::kWaiting;
    out.missing = "a finer scale: it still gets better";
  }
  return out;
}

/// The same window, not solved yet, where theta is free along some of its directions alone.
StartWindow StartWindow::with_open(const std::vector<Index>& open) const {
  StartWindow out = *this;
  out.agreed.reset();
  out.model.directions = model.directions(Eigen::all, open);
  for (std::vector<WindowFrame>* some : {&out.frames, &out.solution->frames}) {
    for (WindowFrame& frame : *some) {
      frame.theta = frame.theta(open).eval();
    }
  }
  return out;
}

/// Where nothing has told the scale, the solution's is anyone's, and a filter that is linearised there learns
/// nonsense. As good a solution is one with the rig's scale, if the pixels are as near to where it sees them,
/// or would be if it were turned or moved across the lines along which depths are seen. What is known of it,
/// the scale among it, stays what is known without the rig.
void StartWindow::take_scale_of_rig() {
  if (of_rig || !unused.empty() || !model.right) {
    return;
  }
  for (const std::vector<Index>& open : {std::vector<Index>{}, across_disparities(model)}) {
    auto there = std::make_shared<StartWindow>(with_open(open));
    there->solution.reset();
    there->solve();
    if (there->solution && there->normal.cost < kFitsTheSame * normal.cost && move_to(*there, open)) {
      of_rig = open.empty() ? std::move(there) : nullptr;
      return;
    }
  }
}

/// To another window's solution, whose theta is open along these directions. @return whether it may be used
bool StartWindow::move_to(const StartWindow& other, const std::vector<Index>& open) {
  WindowState state = *other.solution;
  for (WindowFrame& frame : state.frames) {
    Eigen::VectorXd theta = Eigen::VectorXd::Zero(model.directions.cols());
    theta(open) = frame.theta;
    frame.theta = std::move(theta);
  }
  model.R_first = other.model.R_first;
  WindowNormal there = linearise(model, state);
  MatrixXd known = frame_covariance(there);
  if (known.size() == 0) {
    return false;
  }
  solution = std::move(state);
  normal = std::move(there);
  covariance = std::move(known);
  return true;
}

/// The same window with the rig as it is, for a method that trusts it until it is proven wrong: if the start
/// is over, and what this window knows of the rig proves nothing.
std::optional<StartWindow> StartWindow::trusting(StartStatus status) const {
  if (of_rig) {
    return *of_rig;
  }
  if (!solution || status == StartStatus::kWaiting || !unused.empty()) {
    return std::nullopt;
  }
  const double noise = std::max(normal.cost / expected_cost(model, *solution), 1.0);
  if (!looks_sound(rig_offset(model, *solution, covariance, noise))) {
    return std::nullopt;
  }
  StartWindow out = with_open({});
  out.settle_solution();
  const bool fits_as_well = out.solution && out.normal.cost < kFitsAsWell * normal.cost;
  return fits_as_well ? std::optional(std::move(out)) : std::nullopt;
}

/// A clock that steps looks like one that is off, by what it is for most of the window: where images and
/// inputs agreed better before, a step may explain more.
bool StartWindow::learn_clock_or_step(Asked asked) {
  if (!may_learn_clock()) {
    return false;
  }
  if (!agreed || misfit() <= kAgrees * least_misfit) {
    return learn_clock(asked);
  }
  StartWindow stepped = *this;
  const bool learned = learn_clock(asked);
  const bool explained = learned && misfit() > kAgrees * least_misfit && stepped.explain_by_clock() &&
                         stepped.normal.cost < kFitsMuchBetter * normal.cost;
  if (explained) {
    *this = std::move(stepped);
  }
  return learned;
}

/// Once in a window the biases may step.
bool StartWindow::explain_by_step() {
  if (!solution || stepped_before_ns) {
    return false;
  }
  std::optional<BiasStep> step = find_bias_step(model, *solution, normal);
  if (!step) {
    return false;
  }
  const MatrixXd of_step = frame_covariance(step->normal);
  if (of_step.size() == 0) {
    return false;
  }
  stepped_before_ns = step->before_ns;
  solution = std::move(step->state);
  normal = std::move(step->normal);
  covariance = of_step;
  return true;
}

/// Squared residuals of the solution, over those of pixels as good as assumed.
double StartWindow::misfit() const { return normal.cost / expected_cost(model, *solution); }

/// Whatever pixels are worth, they are worth the same later on: a fault of the inputs makes the misfit grow.
/// At rest points take on what lasts of a pixel's error, of which a motion shows more; tracks of a second are
/// finer than older ones. No solution at all is none that agrees.
bool StartWindow::disagrees() {
  if (!solution) {
    return agreed.has_value();
  }
  const double now = misfit();
  const double fine = fine_pixels(model) * fine_pixels(model);
  const double least = moves() ? fine : std::max(fine, kLeastAtRest);
  least_misfit = std::min(least_misfit, std::max(now, least));
  if (now <= kAgrees * least_misfit) {
    agreed = Agreed{frames.size(), *solution, normal, covariance};
  }
  return agreed && now > kDisagrees * least_misfit;
}

/// To where images and inputs agreed last.
void StartWindow::go_back() {
  solution = std::move(agreed->solution);
  normal = std::move(agreed->normal);
  covariance = std::move(agreed->covariance);
  const auto end = static_cast<std::ptrdiff_t>(agreed->frames);
  unused.assign(raw.begin() + end, raw.end());
  raw.erase(raw.begin() + end, raw.end());
  frames.erase(frames.begin() + end, frames.end());
  solved_s = length();
}

/// The last frame and the map; of their scale no more than the motion can tell.
InitialState StartWindow::handed_over() const {
  InitialState out = hand_over(model, *solution, normal, covariance);
  out.scale_told = scale_told;
  out.imu_noise = model.imu_noise;
  out.body_covariance = seen_from_first(rest_seen_since(), out.nav, out.body_covariance);
  if (leaves_scale_open()) {
    take_noise_from_scale(out);
  }
  out.by_parameters = by_parameters(shifted, model, out);
  if (clock_step && !clock_step->jumps()) {
    out.clock_offset_ns = clock_step->offset_ns;
  }
  if (shifted_by_clock) {
    out.clock_sigma = shifted_by_clock->sigma;
    out.by_clock = by_one(*shifted_by_clock, model, out);
  }
  return out;
}

double way_of(const WindowState& state) {
  double way = 0.0;
  for (const WindowFrame& frame : state.frames) {
    way = std::max(way, frame.nav.T_world_body.p.norm());
  }
  return way;
}

double parallax(const WindowState& state) {
  return way_of(state) * std::max(median_inverse_depth(state), 0.0);
}

}  // namespace limber::detail
