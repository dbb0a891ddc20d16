// SPDX-License-Identifier: MIT
#include "limber/run/smooth_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "limber/clean/frame_cleaner.hpp"
#include "limber/core/chi_square.hpp"
#include "trajectory_row.hpp"

namespace limber {
namespace {

using Clock = std::chrono::steady_clock;
using L = StateLayout;

/// Frames that one problem may have: beyond, its covariance alone takes gigabytes.
constexpr std::size_t kMostFrames = 2500;
constexpr int kMaxIterations = 100;
// What is known of an automatic start beforehand: where the world's origin and axes are, and plausible
// biases.
constexpr double kPriorTilt = 0.5;       // [rad]
constexpr double kPriorVelocity = 30.0;  // [m/s]
constexpr double kPriorRate = 10.0;      // [rad/s]
constexpr double kPriorBiasGyro = 0.1;   // [rad/s]
constexpr double kPriorBiasAccel = 0.1;  // [m/s^2]
constexpr double kYaw = 1e-4;            // [rad], by convention zero
constexpr double kLargestMisfit = 4.0;   // squared residuals per degree of freedom that are said
constexpr std::size_t kShareOfGuess = 30, kShareOfAll = 100;  // [%] of the work

/// A filter's states, where the iteration begins.
struct Guess {
  RunRecord record;
  std::vector<NavigationState> states;
};

/// Asks the source for each frame once and keeps it.
class KeptFrames {
 public:
  explicit KeptFrames(const FrameSource& source) : source_(source) {}
  StereoFrame operator()(std::size_t n) {
    while (frames_.size() <= n) {
      frames_.push_back(source_(frames_.size()));
    }
    return frames_[n];
  }
  /// Those from `first_ns` on.
  [[nodiscard]] std::vector<StereoFrame> from(std::int64_t first_ns) const {
    std::vector<StereoFrame> out;
    std::copy_if(frames_.begin(), frames_.end(), std::back_inserter(out),
                 [&](const StereoFrame& frame) { return frame.t_ns >= first_ns; });
    return out;
  }

 private:
  const FrameSource& source_;
  std::vector<StereoFrame> frames_;
};

/// The states of the moments from which a start was made, which no filter went through.
std::vector<NavigationState> states_before(const std::vector<TrajectoryRow>& rows, std::size_t count) {
  std::vector<NavigationState> out;
  for (std::size_t k = 0; k < count; ++k) {
    NavigationState state;
    state.t_ns = rows[k].t_ns;
    state.T_world_body = rows[k].T_world_body;
    state.v_world_body = rows[k].v_world_body.value_or(Eigen::Vector3d::Zero());
    state.bias_gyro = rows[k].bias_gyro.value_or(Eigen::Vector3d::Zero());
    state.bias_accel = rows[k].bias_accel.value_or(Eigen::Vector3d::Zero());
    out.push_back(state);
  }
  return out;
}

Guess guess_by(Method method, const Recording& recording, RunOptions options, KeptFrames& frames,
               const std::function<void(std::size_t)>& progress) {
  options.method = method;
  options.constraints.reset();
  options.estimated.setZero();
  options.softened.setZero();
  options.watch = false;
  options.cleaning.clean = false;  // its frames are clean already
  Guess out;
  out.record = run_recording(
      recording, options, [&frames](std::size_t n) { return frames(n); }, progress,
      [&out](const ObservedFrame& frame) {
        if (frame.navigator != nullptr) {
          out.states.push_back(frame.navigator->estimate().nav);
        }
      });
  const std::vector<NavigationState> before =
      states_before(out.record.trajectory, out.record.trajectory.size() - out.states.size());
  out.states.insert(out.states.begin(), before.begin(), before.end());
  return out;
}

/// A start from sensors was made from the same pixels and samples: of that, only the choice of the world's
/// axes and the plausible sizes of the biases are information of their own.
InitialState without_data(const NavigationState& first, MotionModel motion) {
  InitialSigma sigma;
  sigma.attitude = kYaw;
  sigma.velocity = kPriorVelocity;
  sigma.bias_gyro = kPriorBiasGyro;
  sigma.bias_accel = kPriorBiasAccel;
  sigma.rate = kPriorRate;
  InitialState start = make_initial_state(first, motion, sigma);
  if (motion == MotionModel::kImu) {
    const Eigen::Matrix3d& R = first.T_world_body.R;
    const Eigen::Vector3d world(kPriorTilt, kPriorTilt, kYaw);
    start.body_covariance.block<3, 3>(L::kAttitude, L::kAttitude) =
        R.transpose() * world.cwiseAbs2().asDiagonal() * R;
  }
  return start;
}

/// What is known of the first state beside the data.
InitialState prior_of(const Guess& guess, const RunOptions& options) {
  return options.start == StartMode::kGroundTruth ? guess.record.start
                                                  : without_data(guess.states.front(), guess.record.motion);
}

SmootherOptions smoother_options(const SmoothOptions& options, const RunSetup& setup,
                                 std::vector<std::string>& notes) {
  const NavigatorOptions& navigator = setup.navigator;
  SmootherOptions out;
  out.motion = navigator.motion;
  out.noise = {navigator.imu_noise, navigator.odometry_noise, navigator.constant_velocity_noise};
  out.sigma_px = navigator.sigma_px;
  out.gravity = navigator.gravity;
  out.rig = options.rig;
  out.piece_s = options.piece_s;
  out.trust_length = options.rig != RigModel::kTrusted && !has_scale(navigator.motion);
  if (out.trust_length) {
    notes.emplace_back("theta: nothing but the baseline's length fixes the scale, so it is trusted");
  }
  out.rig_sigma = options.run.theta_sigma.value_or(RigParameters::Zero());
  out.rig_walk = navigator.theta_walk.value_or(default_theta_walk(setup.calibration.baseline()));
  out.estimated = options.run.estimated;
  out.loss = options.loss;
  out.forget_after_s = navigator.map.forget_after_s;
  out.max_iterations = kMaxIterations;
  out.threads = options.threads;
  return out;
}

CalibrationRow calibration_row(const SmoothedFrame& frame, const SmootherResult& result,
                               const StereoCalibration& given, const SmootherOptions& options) {
  CalibrationRow row;
  row.t_ns = frame.nav.t_ns;
  row.estimate.error = result.error;
  row.estimate.sigma = result.error_sigma;
  row.estimate.parameters = parameters_of(result.error_sigma);
  if (options.rig != RigModel::kTrusted) {
    row.estimate.parameters |= parameters_of(ParameterBlock::kTheta);
    row.estimate.error.head<6>() = frame.theta - given.theta;
    row.estimate.sigma.head<6>() = frame.theta_covariance.diagonal().cwiseSqrt();
  }
  return row;
}

TrajectoryRow row_of(const SmoothedFrame& frame, MotionModel motion) {
  TrajectoryRow row = detail::trajectory_row(frame.nav, motion, frame.pose_covariance);
  if (motion == MotionModel::kOdometry) {
    row.v_world_body.reset();  // no unknown of the problem
  }
  return row;
}

FrameReport frame_report(const SmoothedFrame& frame, double dof_per_row) {
  FrameReport out;
  out.t_ns = frame.nav.t_ns;
  out.status = UpdateStatus::kUpdated;
  out.observed = frame.observed;
  out.used = frame.used;
  out.nis = frame.squared_residuals;
  out.dof = std::lround(dof_per_row * static_cast<double>(frame.rows));
  return out;
}

RunRecord to_record(const SmootherResult& result, const StereoCalibration& given,
                    const SmootherOptions& options) {
  RunRecord out;
  out.motion = options.motion;
  double rows = 0.0, squares = 0.0;
  for (const SmoothedFrame& frame : result.frames) {
    rows += static_cast<double>(frame.rows);
    squares += frame.squared_residuals;
  }
  const double misfit =
      result.squared_residuals / static_cast<double>(std::max<std::ptrdiff_t>(1, result.dof));
  const double dof_per_row = rows > 0.0 && misfit > 0.0 ? std::min(1.0, squares / (misfit * rows)) : 0.0;
  for (const SmoothedFrame& frame : result.frames) {
    out.trajectory.push_back(row_of(frame, options.motion));
    out.frames.push_back(frame_report(frame, dof_per_row));
    const CalibrationRow row = calibration_row(frame, result, given, options);
    if (row.estimate.parameters.any()) {
      out.calibration.push_back(row);
    }
  }
  for (const RefusedPixel& pixel : result.refused) {
    out.frames[pixel.frame].refused.push_back({pixel.track_id, RefusalReason::kGate, pixel.distance,
                                               chi_square_quantile(options.gate_probability, 2.0)});
  }
  out.landmarks = result.landmarks;
  out.theta = result.frames.back().theta;
  if (misfit > kLargestMisfit) {
    out.notes.push_back(fmt::format(
        "squared residuals are {:.1f} times what the noise says: sigmas are too small by about {:.1f}",
        misfit, std::sqrt(misfit)));
  }
  return out;
}

}  // namespace

RigModelText rig_model_from_string(const std::string& text) {
  constexpr std::string_view kPiecewise = "piecewise:";
  for (const RigModel rig : {RigModel::kTrusted, RigModel::kConstant, RigModel::kWalk, RigModel::kFree}) {
    if (text == to_string(rig)) {
      return {rig, 0.0};
    }
  }
  if (text.starts_with(kPiecewise)) {
    double seconds = 0.0;
    const char* end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data() + kPiecewise.size(), end, seconds);
    if (error == std::errc{} && rest == end && std::isfinite(seconds) && seconds > 0.0) {
      return {RigModel::kPiecewise, seconds};
    }
  }
  throw std::invalid_argument("expected trusted, constant, piecewise:SECONDS, walk or free, found '" + text +
                              "'");
}

std::string to_string(RigModel rig) {
  switch (rig) {
    case RigModel::kTrusted:
      return "trusted";
    case RigModel::kConstant:
      return "constant";
    case RigModel::kPiecewise:
      return "piecewise";
    case RigModel::kWalk:
      return "walk";
    case RigModel::kFree:
      break;
  }
  return "free";
}

RunRecord smooth_recording(const Recording& recording, const SmoothOptions& options,
                           const FrameSource& source, const std::function<void(std::size_t)>& progress) {
  const auto begin = Clock::now();
  const RunSetup setup = set_up_run(recording, options.run);
  std::vector<std::string> notes = setup.notes;
  std::erase_if(notes, [](const std::string& note) { return note.starts_with("constraints "); });
  const SmootherOptions how = smoother_options(options, setup, notes);
  FrameCleaner cleaner(setup.calibration, options.run.cleaning);
  const FrameSource cleaned = [&](std::size_t n) { return cleaner.clean(source(n)); };
  KeptFrames kept(cleaned);
  const auto told = [&](std::size_t share) {
    if (progress) {
      progress(share);
    }
  };

  std::vector<Method> methods = {Method::kEkf, Method::kLcekf};
  if (options.guess) {
    methods = {*options.guess};
  }
  std::optional<Guess> best;
  std::optional<double> best_cost;
  std::string failures;
  for (std::size_t k = 0; k < methods.size(); ++k) {
    try {
      Guess guess = guess_by(methods[k], recording, options.run, kept, [&](std::size_t n) {
        told(kShareOfGuess * (k * frame_count(recording) + n) / (methods.size() * frame_count(recording)));
      });
      const std::vector<StereoFrame> frames = kept.from(guess.record.trajectory.front().t_ns);
      const double cost = cost_of_start(
          {frames, recording.imu, recording.odometry, guess.states, prior_of(guess, options.run)},
          setup.calibration, how);
      if (!best_cost || cost < *best_cost) {
        best_cost = cost;
        best = std::move(guess);
      }
    } catch (const std::runtime_error& error) {
      failures += std::string(failures.empty() ? "" : "; ") + error.what();
    }
  }
  if (!best) {
    throw std::runtime_error("smooth: no first guess: " + failures);
  }

  const std::vector<StereoFrame> frames = kept.from(best->record.trajectory.front().t_ns);
  if (frames.size() > kMostFrames) {
    throw std::invalid_argument(fmt::format("smooth: expected at most {} frames in one problem, found {}",
                                            kMostFrames, frames.size()));
  }
  const InitialState prior = prior_of(*best, options.run);
  const SmootherResult result = smooth(
      {frames, recording.imu, recording.odometry, best->states, prior}, setup.calibration, how,
      [&](int iteration) {
        told(kShareOfAll - (kShareOfAll - kShareOfGuess) * 10 / (10 + static_cast<std::size_t>(iteration)));
      });
  if (!result.converged) {
    throw std::runtime_error(fmt::format("smooth: no solution after {} iterations", result.iterations));
  }
  RunRecord record = to_record(result, setup.calibration, how);
  notes.push_back(fmt::format("smoothed over all {} frames at once, theta {}: {} iterations", frames.size(),
                              to_string(options.rig), result.iterations));
  notes.insert(notes.end(), record.notes.begin(), record.notes.end());
  record.notes = std::move(notes);
  record.cleaning = cleaner.report();
  const std::vector<std::string> removed = in_words(record.cleaning);
  record.notes.insert(record.notes.end(), removed.begin(), removed.end());
  record.start = best->record.start;
  record.source_ms = best->record.source_ms;
  const double source_ms = std::accumulate(record.source_ms.begin(), record.source_ms.end(), 0.0);
  const double spent_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  record.frame_ms.assign(frames.size(),
                         std::max(0.0, spent_ms - source_ms) / static_cast<double>(frames.size()));
  return record;
}

}  // namespace limber
