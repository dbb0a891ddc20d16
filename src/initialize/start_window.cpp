// SPDX-License-Identifier: MIT
#include "start_window.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "limber/core/time.hpp"
#include "navigate/parameter_roles.hpp"
#include "window_guess.hpp"
#include "window_pixels.hpp"

namespace limber::detail {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double kGrowth = 1.4;  // of the window, from one solution to the next
/// A body whose motion nobody states may move that much more: images tell it all, and rounds of a solution
/// mind no wide prior.
constexpr double kLivelier = 10.0;
constexpr int kStartIterations = 25;
constexpr int kCleanings = 10;
constexpr double kSamePlace = 1e-4;      // of the cost, by which two solutions differ
constexpr int kMoreIterations = 75;      // of a solution that fits and has not settled
constexpr std::size_t kMostFrames = 64;  // of a window: the cost goes with its cube
constexpr double kUnseenWay = 1.0;       // [m] that a body goes while no point shows it
constexpr double kMuchBetter = 2.0;      // by the cost
constexpr double kFits = 1.0;            // cost over the expected one
constexpr double kFewestKept = 0.1;      // of the points of a solution
constexpr double kFitsUnstated = 0.15;   // of pixels whose noise nobody stated: less than 0.4 px rms

/// What of theta a method leaves free: nothing if it trusts the rig and the lenses.
MatrixXd free_directions(const NavigatorOptions& options, const StereoCalibration& calibration) {
  switch (options.method) {
    case Method::kMonoLeft:
      return MatrixXd(6, 0);
    case Method::kEkf:
      if (doubts_lenses(options)) {
        break;
      }
      return MatrixXd(6, 0);
    case Method::kLcekf:
      return constraint_directions(options.constraints, calibration.theta);
    case Method::kEkfFull:
    case Method::kSoft:
    case Method::kConsider:
    case Method::kAdaptive:
    case Method::kOracle:  // knows the truth of the frames to come, not of those before
      break;
  }
  return constraint_directions(default_constraints(options.motion), calibration.theta);
}

/// The residuals are no larger than that share of the noise.
bool fits(const WindowModel& model, const WindowState& state, const WindowNormal& normal,
          double share = kFits) {
  return normal.cost < share * expected_cost(model, state) + 10.0;
}

bool hardly_left(const WindowState& without_mismatches, const WindowState& whole) {
  return static_cast<double>(without_mismatches.points.size()) <
         kFewestKept * static_cast<double>(whole.points.size());
}

/// With all points far away a body may go wherever its inputs and their biases let it.
bool goes_unseen(const WindowState& state) {
  return way_of(state) > kUnseenWay && parallax(state) <= kSeenParallax;
}

/// Mismatches, which the first solutions still hold, cost less where a body goes unseen. Such a solution has
/// to be much better than one that is seen.
double weighed(const WindowNormal& normal, const WindowState& state) {
  return goes_unseen(state) ? kMuchBetter * normal.cost : normal.cost;
}

/// Which way is ahead is a convention, and has to be the same in each solution: all is turned about the
/// vertical until the first attitude is as near to R as can be.
void turn_to(const Matrix3d& R, WindowState& state) {
  const Matrix3d M = R * state.frames.front().nav.T_world_body.R.transpose();
  const Matrix3d turn = so3_exp(Vector3d(0.0, 0.0, std::atan2(M(1, 0) - M(0, 1), M(0, 0) + M(1, 1))));
  for (WindowFrame& frame : state.frames) {
    NavigationState& nav = frame.nav;
    nav.T_world_body = {turn * nav.T_world_body.R, turn * nav.T_world_body.p};
    nav.v_world_body = turn * nav.v_world_body;
  }
}

/// The unknowns of a solution that has lost some of the points.
void take_values(const WindowState& from, WindowState& to) {
  to.frames = from.frames;
  auto known = from.points.begin();
  for (WindowPoint& point : to.points) {
    if (known != from.points.end() && known->anchor() == point.anchor() &&
        known->landmark.track_id == point.landmark.track_id) {
      point.landmark = known->landmark;
      ++known;
    }
  }
}

}  // namespace

WindowModel window_model(const NavigatorOptions& options, const StereoCalibration& calibration) {
  WindowModel out;
  out.options = options;
  out.calibration = calibration;
  out.directions = free_directions(options, calibration);
  out.right = options.method != Method::kMonoLeft;
  if (options.learn_motion_noise) {
    out.options.constant_velocity_noise.acceleration_density *= kLivelier;
    out.options.constant_velocity_noise.angular_acceleration_density *= kLivelier;
  }
  return out;
}

StartWindow::StartWindow(const NavigatorOptions& navigator, const StereoCalibration& calibration,
                         const StartOptions& start)
    : options(start), checks(limits_of(navigator.motion)) {
  check_calibration(calibration);
  model = window_model(navigator, calibration);
}

Matrix3d StartWindow::assumed_attitude() const {
  if (model.options.motion == MotionModel::kOdometry && model.calibration.body == BodyFrame::kImu) {
    return Matrix3d::Identity();
  }
  Matrix3d R_world_cam0;
  R_world_cam0 << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return R_world_cam0 * body_from_cam0(model.calibration).R.transpose();
}

InputReport StartWindow::push(const StereoFrame& frame) {
  check_points(frame);
  if (!raw.empty() && frame.t_ns <= raw.back().t_ns) {
    throw std::invalid_argument("start: frame at " + std::to_string(frame.t_ns) +
                                " ns is not later than the one before");
  }
  withdraw_from(raw, frame);
  InputReport inputs_told = report_inputs(frame.t_ns);
  WindowFrame next;
  next.theta = VectorXd::Zero(model.directions.cols());
  if (!raw.empty()) {
    if (model.options.motion == MotionModel::kConstantVelocity) {
      InputStep step;
      step.t_end_ns = frame.t_ns;
      step.dt = seconds_between(raw.back().t_ns, frame.t_ns);
      next.steps = {step};
    } else {
      next.steps = inputs.steps(raw.back().t_ns, frame.t_ns);
      if (!next.steps.empty()) {
        next.omega = next.steps.back().angular;
      }
    }
  }
  next.nav.t_ns = frame.t_ns;
  frames.push_back(std::move(next));
  raw.push_back(frame);
  return inputs_told;
}

/// Of the samples since the last frame.
InputReport StartWindow::report_inputs(std::int64_t t_ns) {
  if (model.options.motion == MotionModel::kConstantVelocity) {
    return {};
  }
  const std::int64_t late_ns = clock_step ? std::max<std::int64_t>(clock_step->offset_ns, 0) : 0;
  return report_on(inputs, checks.take_counts(), (raw.empty() ? t_ns : raw.back().t_ns) - late_ns,
                   t_ns - late_ns);
}

/// At most kMostFrames of the window, evenly spaced, the first and the last among them.
StartWindow::Frames StartWindow::kept() const {
  const std::size_t stride = (frames.size() + kMostFrames - 1) / kMostFrames;
  Frames out;
  std::vector<InputStep> steps;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    steps.insert(steps.end(), frames[k].steps.begin(), frames[k].steps.end());
    if (k == 0 || (frames.size() - 1 - k) % stride == 0) {
      out.frames.push_back(frames[k]);
      WindowFrame& frame = out.frames.back();
      frame.steps = std::exchange(steps, {});
      if (stepped_before_ns && !out.raw.empty() && out.raw.back().t_ns < *stepped_before_ns &&
          *stepped_before_ns <= frame.nav.t_ns) {
        open_biases(frame);
      }
      out.raw.push_back(raw[k]);
    }
  }
  return out;
}

/// A solution carried on to frames and points that came since.
WindowState StartWindow::continued(const WindowState& from, const Frames& now) const {
  WindowState out{now.frames, points_of(model, now.raw)};
  auto known = from.frames.begin();
  for (std::size_t k = 0; k < out.frames.size(); ++k) {
    WindowFrame& frame = out.frames[k];
    while (known != from.frames.end() && known->nav.t_ns < frame.nav.t_ns) {
      ++known;
    }
    if (known != from.frames.end() && known->nav.t_ns == frame.nav.t_ns) {
      frame.nav = known->nav;
      frame.theta = known->theta;
    } else if (k > 0) {
      frame.nav = out.frames[k - 1].nav;
      frame.theta = out.frames[k - 1].theta;
      (void)predict_over(model.options, frame, frame.nav);
    }
  }
  for (WindowPoint& point : out.points) {
    point.landmark.value.setZero();
  }
  fill_depths_from_motion(model, out);
  drop_unreachable(model, out);
  return out;
}

/// The last solution, and the last one that images and inputs agreed upon, if that is another one.
std::vector<WindowState> StartWindow::continuations(const Frames& now) const {
  std::vector<WindowState> out;
  if (solution) {
    out.push_back(continued(*solution, now));
  }
  if (agreed && (failed_before || !solution)) {
    out.push_back(continued(agreed->solution, now));
  }
  return out;
}

/// Solved again where the window has grown enough, and at the end of its time.
bool StartWindow::is_due() const {
  const double now_s = length();
  const auto ends = [&](double longest_s) { return now_s >= longest_s && solved_s < longest_s; };
  const double solved_ago_s = now_s - solved_s;
  const bool time_is_over = is_out_of_time() && waited_s() - solved_ago_s < options.longest_still_s;
  const bool has_grown = now_s >= options.shortest_s && now_s >= kGrowth * solved_s;
  return time_is_over || ends(options.longest_s) || ends(options.longest_moving_s) ||
         ends(options.longest_fine_s) || (has_grown && !still_rests());
}

/// A solution that fits may take its time until it has settled; others are left. At rest what a motion will
/// tell is weakly known, and settles slowly: nobody waits for that.
WindowNormal StartWindow::settled(WindowState& guess) const {
  WindowNormal out = solve_window(model, guess, kStartIterations);
  const bool resting = is_over_by_motion() && !is_out_of_time() && parallax(guess) <= kSeenParallax;
  return !resting && fits(model, guess, out) && out.left > kSettled
             ? solve_window(model, guess, kMoreIterations)
             : std::move(out);
}

/// Noise that is not stated may be much less than it is taken for, and then a solution far off fits, too.
/// What the best one so far left is known.
double StartWindow::good_fit() const {
  return model.options.learn_pixel_noise
             ? std::clamp(least_misfit == kUnknown ? 0.0 : kAgrees * least_misfit, kFitsUnstated, kFits)
             : kFits;
}

/// Mismatches outweigh all else in the cost of a guess, and keep it from settling. Most are far off; what is
/// left shows where it settles without those.
StartWindow::Place StartWindow::without_mismatches(Place from) const {
  if (drop_mismatches(model, from.state, from.state.frames.size()) > 0) {
    from.normal = settled(from.state);
  }
  return from;
}

/// Where it fits without mismatches it is the solution, with all of its pixels. What leaves hardly a point
/// fits anything.
bool StartWindow::take_if_it_fits(const WindowState& guess, const Place& without) {
  if (hardly_left(without.state, guess) || goes_unseen(without.state) ||
      !fits(model, without.state, without.normal, good_fit()) ||
      contradicted_from(guess, without.state) < guess.frames.size()) {
    return false;
  }
  solution = guess;
  take_values(without.state, *solution);
  normal = linearise(model, *solution);
  normal.left = promised_decrease(normal);
  return true;
}

/// Without what is far off it may be known to be no better than the one before; else it settles with all.
StartWindow::Tried StartWindow::try_guess(WindowState guess) {
  if (model.options.motion == MotionModel::kImu) {
    model.R_first = guess.frames.front().nav.T_world_body.R;
  }
  Place near{guess, {}};
  if (drop_far_off(model, near.state)) {
    near.normal = settled(near.state);
    near = without_mismatches(std::move(near));
    if (take_if_it_fits(guess, near)) {
      return Tried::kFits;
    }
    if (solution && near.normal.cost >= weighed(normal, *solution)) {
      return Tried::kNoBetter;
    }
  }
  Place there{std::move(guess), {}};
  there.normal = settled(there.state);
  const bool fits_whole = fits(model, there.state, there.normal, good_fit());
  const bool has_settled = there.normal.left <= kSettled;
  if (!fits_whole && has_settled && take_if_it_fits(there.state, without_mismatches(there))) {
    return Tried::kFits;
  }
  const bool same_place = solution && std::abs(there.normal.cost - normal.cost) < kSamePlace * normal.cost;
  const bool better = !solution || weighed(there.normal, there.state) < weighed(normal, *solution);
  if (better) {
    normal = std::move(there.normal);
    solution = std::move(there.state);
  }
  return fits_whole && better ? Tried::kFits : same_place ? Tried::kSamePlace : Tried::kNoBetter;
}

/// Those that carry on what was known, then new ones, until one fits, or a new one leads to where another
/// did.
void StartWindow::try_guesses(const Frames& now) {
  std::vector<WindowState> carried_on = continuations(now);
  solution.reset();
  if (std::ranges::any_of(
          carried_on, [this](WindowState& guess) { return try_guess(std::move(guess)) == Tried::kFits; })) {
    return;
  }
  for (WindowState& guess : guesses(model, now.frames, now.raw)) {
    if (try_guess(std::move(guess)) != Tried::kNoBetter) {
      return;
    }
  }
}

void StartWindow::solve() {
  if (clock_step) {
    read_inputs_anew();  // samples that are stamped late came after their frames
  }
  const Frames now = kept();
  if (model.options.motion == MotionModel::kConstantVelocity) {
    model.R_first = assumed_attitude();
  }
  try_guesses(now);
  if (R_first) {
    turn_to(*R_first, *solution);
  }
  R_first = model.R_first = solution->frames.front().nav.T_world_body.R;
  const double left = normal.left;
  normal = linearise(model, *solution);
  normal.left = left;
  clean_and_cover();
  solved_s = length();
}

/// The solution again, for a model that is another one now.
void StartWindow::settle_solution() {
  normal = settled(*solution);
  clean_and_cover();
}

/// Takes mismatches out of the solution, but for the frames from `end` on.
void StartWindow::clean(std::size_t end) {
  int round = 0;
  while (round < kCleanings && drop_mismatches(model, *solution, end) > 0) {
    normal = solve_window(model, *solution, 1);  // it has hardly far to go
    ++round;
  }
  if (round > 0) {
    normal = settled(*solution);
  }
}

/// The solution without mismatches; what it knows then. One that leaves hardly a point is none. Where inputs
/// fail at its end, pixels that say so are no mismatches: they stay, and the misfit shows it.
void StartWindow::clean_and_cover() {
  WindowState whole = *solution;
  clean(whole.frames.size());
  const std::size_t contradicted = contradicted_from(whole, *solution);
  if (contradicted < whole.frames.size() && model.options.motion == MotionModel::kImu) {
    take_values(*solution, whole);
    solution = whole;
    (void)drop_mismatches(model, *solution, contradicted);
    normal = settled(*solution);
    clean(contradicted);
  }
  covariance = frame_covariance(normal);
  if (covariance.size() == 0 || hardly_left(*solution, whole)) {
    solution.reset();
  }
}

}  // namespace limber::detail
