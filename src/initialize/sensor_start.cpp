// SPDX-License-Identifier: MIT
#include "limber/initialize/sensor_start.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "hand_over.hpp"
#include "limber/core/median.hpp"
#include "limber/core/time.hpp"
#include "limber/state/initial_state.hpp"
#include "window_guess.hpp"
#include "window_problem.hpp"

namespace limber {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using namespace detail;
using L = StateLayout;

namespace {

constexpr double kSeenParallax = 0.02;  // [rad], of the usual point
constexpr double kUnknown = std::numeric_limits<double>::infinity();
/// Of a start to which images and inputs say nothing that agrees.
constexpr InitialSigma kNothingKnown{
    .position = 1e-3, .attitude = 0.5, .velocity = 5.0, .bias_accel = 0.5, .bias_gyro = 0.1, .rate = 1.0};
constexpr double kGrowth = 1.4;  // of the window, from one solution to the next
constexpr int kStartIterations = 25;
constexpr int kCleanings = 10;
constexpr int kMoreIterations = 75;  // of a solution that fits and has not settled
constexpr double kSettled = 0.02;    // of the cost, still to come: no unknown is off by more than 0.2 sigma
constexpr std::size_t kMostFrames = 64;  // of a window: the cost goes with its cube
constexpr double kFits =
    1.0;  // cost per degree of freedom (expected: 1/2) up to which no other guess is tried

/// Misfit over the least of all solutions: of one that can be gone back to, of one that contradicts it.
constexpr double kAgrees = 1.4, kDisagrees = 3.0;

/// What of theta a method leaves free: nothing if it trusts the rig.
MatrixXd free_directions(const NavigatorOptions& options, const StereoCalibration& calibration) {
  switch (options.method) {
    case Method::kEkf:
    case Method::kMonoLeft:
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
  ConstraintSet all;
  all.kind = has_scale(options.motion) ? ConstraintSet::Kind::kFull : ConstraintSet::Kind::kRotationDirection;
  return constraint_directions(all, calibration.theta);
}

/// Where the body is taken to stand if nothing tells: level, or the left camera looking horizontally.
Matrix3d assumed_attitude(const NavigatorOptions& options, const StereoCalibration& calibration) {
  if (options.motion == MotionModel::kOdometry && calibration.body == BodyFrame::kImu) {
    return Matrix3d::Identity();
  }
  Matrix3d R_world_cam0;
  R_world_cam0 << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return R_world_cam0 * body_from_cam0(calibration).R.transpose();
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

/// A solution that images and inputs agreed upon, and how many frames had been there.
struct Agreed {
  std::size_t frames = 0;
  WindowState solution;
  WindowNormal normal;
  MatrixXd covariance;
};

}  // namespace

struct SensorStart::Window {
  WindowModel model;
  StartOptions options;
  InputBuffer inputs;
  InputChecks checks{kImuLimits};
  std::vector<StereoFrame> raw;
  std::vector<WindowFrame> frames;  // with inputs, without states
  std::optional<WindowState> solution;
  std::optional<Matrix3d> R_first;  // of the last solution
  WindowNormal normal;
  MatrixXd covariance;
  double solved_s = 0.0;
  StartReport report{StartStatus::kWaiting, 0.0, kUnknown, kUnknown, "more frames", {}};
  double least_misfit = kUnknown;  // of all solutions, squared residuals over rows
  std::optional<Agreed> agreed;
  bool failed_before = false;                     // the solution before disagreed
  std::optional<std::int64_t> stepped_before_ns;  // the biases, in the interval that holds this
  std::vector<StereoFrame> unused;                // after images and inputs agreed last

  [[nodiscard]] bool is_due(double waited_s) const;
  [[nodiscard]] double length() const {
    return raw.empty() ? 0.0 : seconds_between(raw.front().t_ns, raw.back().t_ns);
  }
  void push(const StereoFrame& frame);
  struct Frames {
    std::vector<WindowFrame> frames;
    std::vector<StereoFrame> raw;
  };
  [[nodiscard]] Frames kept() const;
  [[nodiscard]] std::optional<WindowState> continued(const Frames& now) const;
  [[nodiscard]] std::vector<SmoothedState> trajectory() const;
  [[nodiscard]] SensorStartResult unsolved() const;
  void solve();
  /// The rig says nothing about how long a metre is.
  [[nodiscard]] bool leaves_scale_open() const {
    return !model.right ||
           !(model.directions.bottomRows<3>().transpose() * model.calibration.theta.tail<3>()).isZero();
  }
  [[nodiscard]] StartReport judged() const;
  StartReport solve_and_judge();
  bool explain_by_step();
  [[nodiscard]] bool disagrees();
  void go_back();
  [[nodiscard]] InputReport report_inputs(std::int64_t t_ns);
  [[nodiscard]] double tilt_sigma() const;
  [[nodiscard]] InitialState handed_over() const;
  [[nodiscard]] double scale_sigma() const;
  [[nodiscard]] double parallax() const;
};

void SensorStart::Window::push(const StereoFrame& frame) {
  check_points(frame);
  WindowFrame next;
  next.theta = VectorXd::Zero(model.directions.cols());
  if (!raw.empty()) {
    if (frame.t_ns <= raw.back().t_ns) {
      throw std::invalid_argument("start: frame at " + std::to_string(frame.t_ns) +
                                  " ns is not later than the one before");
    }
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
}

/// At most kMostFrames of the window, evenly spaced, the first and the last among them.
SensorStart::Window::Frames SensorStart::Window::kept() const {
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

/// The last solution carried on to frames and points that came since.
std::optional<WindowState> SensorStart::Window::continued(const Frames& now) const {
  if (!solution) {
    return std::nullopt;
  }
  WindowState out{now.frames, points_of(model, now.raw)};
  auto known = solution->frames.begin();
  for (std::size_t k = 0; k < out.frames.size(); ++k) {
    WindowFrame& frame = out.frames[k];
    while (known != solution->frames.end() && known->nav.t_ns < frame.nav.t_ns) {
      ++known;
    }
    if (known != solution->frames.end() && known->nav.t_ns == frame.nav.t_ns) {
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
  return out;
}

/// Solved again where the window has grown enough, and at the end of its time.
bool SensorStart::Window::is_due(double waited_s) const {
  const auto ends = [&](double longest_s) { return waited_s >= longest_s && solved_s < longest_s; };
  return ends(options.longest_s) || ends(options.longest_moving_s) ||
         (waited_s >= options.shortest_s && waited_s >= kGrowth * solved_s);
}

void SensorStart::Window::solve() {
  std::vector<WindowState> starts;
  const Frames now = kept();
  if (std::optional<WindowState> on = continued(now)) {
    starts.push_back(std::move(*on));
  }
  if (model.options.motion == MotionModel::kConstantVelocity) {
    model.R_first = assumed_attitude(model.options, model.calibration);
  }
  const std::vector<WindowState> fresh = guesses(model, now.frames, now.raw);
  starts.insert(starts.end(), fresh.begin(), fresh.end());
  solution.reset();
  for (WindowState& start : starts) {
    if (model.options.motion == MotionModel::kImu) {
      model.R_first = start.frames.front().nav.T_world_body.R;
    }
    WindowNormal there = solve_window(model, start, kStartIterations);
    const double fits = kFits * expected_cost(model, start) + 10.0;
    if (there.cost < fits && there.left > kSettled) {
      there = solve_window(model, start, kMoreIterations);
    }
    if (!solution || there.cost < normal.cost) {
      normal = std::move(there);
      solution = std::move(start);
    }
    if (normal.cost < fits) {
      break;
    }
  }
  if (R_first) {
    turn_to(*R_first, *solution);
  }
  R_first = model.R_first = solution->frames.front().nav.T_world_body.R;
  const double left = normal.left;
  normal = linearise(model, *solution);
  normal.left = left;
  for (int round = 0; round < kCleanings && drop_mismatches(model, *solution) > 0; ++round) {
    normal = solve_window(model, *solution, kStartIterations);
  }
  covariance = frame_covariance(normal);
  if (covariance.size() == 0) {
    solution.reset();
  }
  solved_s = length();
}

double SensorStart::Window::tilt_sigma() const {
  if (model.options.motion != MotionModel::kImu) {
    return 0.0;
  }
  const Index last = static_cast<Index>(solution->frames.size() - 1) * model.frame_size() + L::kAttitude;
  const Matrix3d& R = solution->frames.back().nav.T_world_body.R;
  const Matrix3d P = R * covariance.block<3, 3>(last, last) * R.transpose();
  return std::sqrt(std::max(P(0, 0), P(1, 1)));
}

/// Of the logarithm of what all inverse depths have in common.
double SensorStart::Window::scale_sigma() const {
  const double information = scale_information(handed_over());
  return information > 0.0 ? 1.0 / std::sqrt(information) : kUnknown;
}

/// What the solution knows of what was asked for.
StartReport SensorStart::Window::judged() const {
  StartReport out;
  out.waited_s = length();
  out.tilt_sigma = solution ? tilt_sigma() : kUnknown;
  out.scale_sigma = solution ? scale_sigma() : kUnknown;
  const bool tilt = out.tilt_sigma <= options.tilt_sigma;
  const bool scale =
      out.scale_sigma <= (leaves_scale_open() ? options.open_scale_sigma : options.scale_sigma);
  const bool settled = !solution || normal.left <= kSettled;
  const bool moves = solution && parallax() > kSeenParallax;
  if (!solution) {
    out.missing = "a motion that images and inputs agree upon";
  } else if (!scale) {
    out.missing = moves ? "no acceleration yet that tells the scale" : "no parallax yet that tells the scale";
  } else if (!settled && tilt) {
    out.missing = "a solution that has settled";
  }
  if (solution && !tilt) {
    out.missing += std::string(out.missing.empty() ? "" : "; ") +
                   "no turn or acceleration yet that tells the tilt from a bias";
  }
  const bool may_be_told = moves && !scale && has_scale(model.options.motion);
  const double longest_s = may_be_told ? options.longest_moving_s : options.longest_s;
  out.status = tilt && scale && settled    ? StartStatus::kReady
               : out.waited_s >= longest_s ? StartStatus::kTimedOut
                                           : StartStatus::kWaiting;
  return out;
}

StartReport SensorStart::Window::solve_and_judge() {
  solve();
  StartReport out = judged();
  bool failed = disagrees();
  if ((failed || out.status != StartStatus::kWaiting) && explain_by_step()) {
    out = judged();
    failed = disagrees();
  }
  // One solution alone may be stuck; the next one, with more frames, mostly is not.
  const bool again = std::exchange(failed_before, failed);
  failed = failed && (again || out.status != StartStatus::kWaiting);
  if (failed) {
    go_back();
    out = judged();
  }
  if (failed) {
    out.status = StartStatus::kTimedOut;
    out.missing +=
        std::string(out.missing.empty() ? "" : "; ") + "what happened then: images and inputs agree no more";
  }
  return out;
}

/// Once in a window the biases may step.
bool SensorStart::Window::explain_by_step() {
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

/// Whatever pixels are worth, they are worth the same later on: a fault of the inputs makes the misfit grow.
bool SensorStart::Window::disagrees() {
  if (!solution) {
    return false;
  }
  const double misfit = normal.cost / expected_cost(model, *solution);
  least_misfit = std::min(least_misfit, misfit);
  if (misfit <= kAgrees * least_misfit) {
    agreed = Agreed{frames.size(), *solution, normal, covariance};
  }
  return agreed && misfit > kDisagrees * least_misfit;
}

/// To where images and inputs agreed last.
void SensorStart::Window::go_back() {
  solution = std::move(agreed->solution);
  normal = std::move(agreed->normal);
  covariance = std::move(agreed->covariance);
  const auto end = static_cast<std::ptrdiff_t>(agreed->frames);
  unused.assign(raw.begin() + end, raw.end());
  raw.erase(raw.begin() + end, raw.end());
  frames.erase(frames.begin() + end, frames.end());
  solved_s = length();
}

/// Of the samples since the last frame.
InputReport SensorStart::Window::report_inputs(std::int64_t t_ns) {
  if (model.options.motion == MotionModel::kConstantVelocity) {
    return {};
  }
  return report_on(inputs, checks.take_counts(), raw.empty() ? t_ns : raw.back().t_ns, t_ns);
}

/// The last frame and the map; of their scale no more than the motion can tell.
InitialState SensorStart::Window::handed_over() const {
  InitialState out = hand_over(model, *solution, normal, covariance);
  if (leaves_scale_open()) {
    take_noise_from_scale(out);
  }
  return out;
}

/// Angle under which the usual point sees the way that the body went [rad].
double SensorStart::Window::parallax() const {
  double way = 0.0;
  for (const WindowFrame& frame : solution->frames) {
    way = std::max(way, frame.nav.T_world_body.p.norm());
  }
  std::vector<double> rho = {0.0};
  for (const WindowPoint& point : solution->points) {
    rho.push_back(point.landmark.value.z());
  }
  return way * std::max(upper_median(std::move(rho)), 0.0);
}

/// Frames that were left out are predicted from the one before.
std::vector<SmoothedState> SensorStart::Window::trajectory() const {
  std::vector<SmoothedState> out;
  const Index n = model.body_size();
  NavigationState nav;
  MatrixXd P;
  std::size_t next = 0;
  for (const WindowFrame& frame : frames) {
    if (next < solution->frames.size() && solution->frames[next].nav.t_ns == frame.nav.t_ns) {
      const Index at = static_cast<Index>(next) * model.frame_size();
      nav = solution->frames[next++].nav;
      P = covariance.block(at, at, n, n);
    } else {
      const Transition step = predict_over(model.options, frame, nav);
      P = step.Phi * P * step.Phi.transpose() + step.Q;
    }
    const Eigen::Matrix<double, 6, 6> pose = P.topLeftCorner<6, 6>();
    out.push_back({nav, 0.5 * (pose + pose.transpose())});
  }
  return out;
}

/// Inputs and images that no motion explains say nothing: at rest at the origin, as far as anybody knows.
SensorStartResult SensorStart::Window::unsolved() const {
  NavigationState nav;
  nav.T_world_body.R = assumed_attitude(model.options, model.calibration);
  SensorStartResult out;
  out.solved = false;
  for (const StereoFrame& frame : raw) {
    nav.t_ns = frame.t_ns;
    InitialSigma sigma = kNothingKnown;
    sigma.position += kNothingKnown.velocity * seconds_between(raw.front().t_ns, frame.t_ns);
    out.initial = make_initial_state(nav, model.options.motion, sigma);
    const MatrixXd& P = out.initial.body_covariance;
    out.trajectory.push_back({nav, P.topLeftCorner<6, 6>()});
  }
  return out;
}

SensorStart::SensorStart(const NavigatorOptions& options, const StereoCalibration& calibration,
                         const StartOptions& start)
    : window_(std::make_unique<Window>()) {
  check_calibration(calibration);
  window_->model.options = options;
  window_->model.calibration = calibration;
  window_->model.directions = free_directions(options, calibration);
  if (options.motion == MotionModel::kOdometry) {
    window_->checks = InputChecks(kOdometryLimits);
  }
  window_->model.right = options.method != Method::kMonoLeft;
  window_->options = start;
}

SensorStart::SensorStart(SensorStart&&) noexcept = default;
SensorStart& SensorStart::operator=(SensorStart&&) noexcept = default;
SensorStart::~SensorStart() = default;

void SensorStart::add_imu(const ImuSample& sample) {
  window_->checks.add({sample.t_ns, sample.omega_imu, sample.accel_imu}, window_->inputs);
}

void SensorStart::add_odometry(const OdometrySample& sample) {
  window_->checks.add({sample.t_ns, sample.omega_body, sample.v_body}, window_->inputs);
}

StartReport SensorStart::add_frame(const StereoFrame& frame) {
  Window& w = *window_;
  const InputReport inputs = w.report_inputs(frame.t_ns);
  if (!w.unused.empty()) {
    w.unused.push_back(frame);
    return w.report;
  }
  w.push(frame);
  if (w.model.options.motion == MotionModel::kOdometry) {
    StartReport ready;
    ready.status = StartStatus::kReady;
    ready.inputs = inputs;
    return ready;
  }
  if (w.report.status == StartStatus::kWaiting) {
    w.report.waited_s = w.length();
    if (w.is_due(w.report.waited_s)) {
      w.report = w.solve_and_judge();
    }
  }
  StartReport out = w.report;
  out.inputs = inputs;
  return out;
}

SensorStartResult SensorStart::result() {
  Window& w = *window_;
  if (w.frames.empty()) {
    throw std::invalid_argument("start: no frame yet");
  }
  SensorStartResult out;
  if (w.model.options.motion == MotionModel::kOdometry) {
    NavigationState nav;
    nav.t_ns = w.raw.back().t_ns;
    nav.T_world_body.R = assumed_attitude(w.model.options, w.model.calibration);
    out.initial = make_initial_state(nav, MotionModel::kOdometry, {});
    out.report.status = StartStatus::kReady;
    return out;
  }
  out.report = !w.solution || w.solved_s < w.length() ? w.solve_and_judge()
               : w.unused.empty()                     ? w.judged()
                                                      : w.report;
  if (w.solution) {
    out.initial = w.handed_over();
    out.trajectory = w.trajectory();
  } else {
    const StartReport report = out.report;
    out = w.unsolved();
    out.report = report;
  }
  out.bias_step_ns = w.stepped_before_ns;
  out.unused = w.unused;
  return out;
}

}  // namespace limber
