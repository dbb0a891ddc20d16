// SPDX-License-Identifier: MIT
#include "limber/run/smooth_recording.hpp"
#include "limber/run/trajectory_row.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
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
#include "limber/core/nearest_word.hpp"
#include "limber/core/time.hpp"
#include "limber/run/rig_parts.hpp"
#include "limber/smooth/causal_smoother.hpp"
#include "run/smooth_setup.hpp"
#include "run/window_record.hpp"

namespace limber {

using detail::Guess, detail::KeptFrames;

namespace {

using Clock = std::chrono::steady_clock;
using Told = std::function<void(std::size_t)>;  // of work, in per cent

/// Frames that one problem may have: beyond, its covariance alone takes gigabytes.
constexpr std::size_t kMostFrames = 2500;
constexpr double kLargestMisfit = 4.0;  // squared residuals per degree of freedom that are said
constexpr double kManyRefused = 0.2;    // of all pixels
constexpr std::size_t kShareOfGuess = 30, kShareOfAll = 100;  // [%] of the work

/// What is known of the first state beside the data.
InitialState prior_of(const Guess& guess, const RunOptions& options) {
  return options.start == StartMode::kGroundTruth
             ? guess.record.start
             : detail::without_data(guess.states.front(), guess.record.motion);
}

/// Of a rig that is constant: the covariance that counts what the points of a part of the image have in
/// common, as recalibration does, in place of that of white pixels.
void count_cells(const StereoCalibration& given, SmootherResult& result) {
  constexpr double kAnySize = 1e3;  // [rad, m]: no axis is left alone
  if (result.theta_scores.empty()) {
    return;
  }
  RigPart whole;
  whole.theta = result.frames.front().theta;
  whole.information = result.frames.front().theta_covariance.inverse();
  whole.scores = result.theta_scores;
  const RigFit fit = fit_rig({&whole, 1}, given.theta, RigParameters::Constant(kAnySize));
  for (SmoothedFrame& frame : result.frames) {
    frame.theta_covariance = fit.covariance;
  }
}

CalibrationRow calibration_row(const SmoothedFrame& frame, const StereoCalibration& given,
                               const SmootherOptions& options) {
  CalibrationRow row;
  row.t_ns = frame.nav.t_ns;
  row.estimate.error = frame.error;
  row.estimate.sigma = frame.error_sigma;
  row.estimate.parameters = parameters_of(frame.error_sigma);
  if (options.rig != RigModel::kTrusted) {
    row.estimate.parameters |= parameters_of(ParameterBlock::kTheta);
    row.estimate.error.head<6>() = frame.theta - given.theta;
    row.estimate.sigma.head<6>() = frame.theta_covariance.diagonal().cwiseSqrt();
  }
  return row;
}

TrajectoryRow row_of(const SmoothedFrame& frame, MotionModel motion) {
  TrajectoryRow row = trajectory_row(frame.nav, motion, frame.pose_covariance, frame.motion_covariance);
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

/// @param length_sigma  by what share all lengths may be wrong, 1σ
RunRecord to_record(const SmootherResult& result, const StereoCalibration& given,
                    const SmootherOptions& options, double length_sigma) {
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
  const Eigen::Vector3d first = result.frames.front().nav.T_world_body.p;
  for (const SmoothedFrame& frame : result.frames) {
    out.trajectory.push_back(row_of(frame, options.motion));
    if (out.trajectory.back().covariance) {  // which no frame tells
      const Eigen::Vector3d by_scale = length_sigma * (frame.nav.T_world_body.p - first);
      out.trajectory.back().covariance->topLeftCorner<3, 3>() += by_scale * by_scale.transpose();
    }
    out.frames.push_back(frame_report(frame, dof_per_row));
    const CalibrationRow row = calibration_row(frame, given, options);
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
  out.theta_assumed = given.theta;
  if (misfit > kLargestMisfit) {
    out.notes.push_back(fmt::format(
        "squared residuals are {:.1f} times what the noise says: sigmas are too small by about {:.1f}",
        misfit, std::sqrt(misfit)));
  }
  const double refused = 2.0 * static_cast<double>(result.refused.size());  // in rows
  if (refused > kManyRefused * (refused + rows)) {
    out.notes.push_back(fmt::format(
        "{:.0f} % of all pixels were refused: mismatches, things that move, or inputs that contradict "
        "the images; the solution may be a wrong one",
        100.0 * refused / (refused + rows)));
  }
  return out;
}

/// The filters' trajectory that explains the pixels best.
/// @throws std::runtime_error if no filter has one
Guess best_guess(const Recording& recording, const SmoothOptions& options, const RunSetup& setup,
                 const SmootherOptions& how, KeptFrames& kept, const Told& told) {
  std::vector<Method> methods = {Method::kEkf, Method::kLcekf};
  if (options.guess) {
    methods = {*options.guess};
  }
  std::optional<Guess> best;
  std::optional<double> best_cost;
  std::string failures;
  for (std::size_t k = 0; k < methods.size(); ++k) {
    try {
      Guess guess = detail::guess_by(methods[k], recording, options.run, kept, [&](std::size_t n) {
        told(kShareOfGuess * (k * frame_count(recording) + n) / (methods.size() * frame_count(recording)));
      });
      const std::vector<StereoFrame> frames = kept.from(guess.record.trajectory.front().t_ns);
      const double cost =
          cost_of_start({frames, guess.imu, recording.odometry, guess.states, prior_of(guess, options.run)},
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
  return *std::move(best);
}

/// Frames of the largest problem.
std::size_t most_at_once(const std::vector<StereoFrame>& frames, const SmoothOptions& options) {
  if (!options.causal_window_s) {
    return frames.size();
  }
  std::size_t most = 0, oldest = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    while (seconds_between(frames[oldest].t_ns, frames[k].t_ns) > *options.causal_window_s) {
      ++oldest;
    }
    most = std::max(most, k - oldest + 1);
  }
  return most;
}

std::string frames_at_once(const std::vector<StereoFrame>& frames, const SmoothOptions& options) {
  return options.causal_window_s
             ? fmt::format("the {} s before each of {} frames", *options.causal_window_s, frames.size())
             : fmt::format("all {} frames at once", frames.size());
}

SmootherResult solve(const Recording& recording, const std::vector<StereoFrame>& frames, const Guess& guess,
                     const SmoothOptions& options, const SmootherOptions& how,
                     const StereoCalibration& calibration, const Told& told) {
  if (const std::size_t found = most_at_once(frames, options); found > kMostFrames) {
    throw std::invalid_argument(
        fmt::format("smooth: expected at most {} frames in one problem, found {}", kMostFrames, found));
  }
  const SmootherInput input{frames, guess.imu, recording.odometry, guess.states,
                            prior_of(guess, options.run)};
  constexpr std::size_t kRest = kShareOfAll - kShareOfGuess;
  if (options.causal_window_s) {
    const std::size_t start = guess.record.frames_of_start;
    return smooth_causally(input, calibration, how, {start > 0 ? start - 1 : 0, *options.causal_window_s},
                           [&](std::size_t n) { told(kShareOfGuess + kRest * n / frames.size()); });
  }
  return smooth(input, calibration, how, [&](int iteration) {
    told(kShareOfAll - kRest * 10 / (10 + static_cast<std::size_t>(iteration)));
  });
}

}  // namespace

RigModelText rig_model_from_string(const std::string& given) {
  const std::string text = in_lower_case(given);
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
  throw std::invalid_argument("expected trusted, constant, piecewise:SECONDS, walk or free, found '" + given +
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

std::string to_string(const SmoothOptions& options) {
  return "smooth-" + to_string(options.rig) + (options.causal_window_s ? "-causal" : "");
}

RunRecord smooth_recording(const Recording& recording, const SmoothOptions& options,
                           const FrameSource& source, const std::function<void(std::size_t)>& progress) {
  const auto begin = Clock::now();
  const RunSetup setup = set_up_run(recording, options.run);
  std::vector<std::string> notes = setup.notes;
  std::erase_if(notes, [](const std::string& note) { return note.starts_with("constraints "); });
  SmootherOptions how = detail::smoother_options(recording, options, setup, notes);
  FrameCleaner cleaner(setup.calibration, options.run.cleaning);
  const FrameSource cleaned = [&](std::size_t n) { return cleaner.clean(source(n)); };
  KeptFrames kept(cleaned);
  const auto told = [&](std::size_t share) {
    if (progress) {
      progress(share);
    }
  };

  const Guess guess = best_guess(recording, options, setup, how, kept, told);
  if (const auto& learned = guess.record.pixel_noise) {
    how.sigma_px.setConstant(learned->sigma_px);
    notes.push_back(
        fmt::format("pixel noise learned by the filter of the first guess: {:.2g} px", learned->sigma_px));
  }
  const double length_sigma = has_scale(how.motion) || !guess.record.pixel_noise
                                  ? setup.navigator.odometry_scale
                                  : guess.record.pixel_noise->length_sigma;
  detail::take_imu_noise(guess.record.imu_noise, how, notes);
  detail::say_clock(guess.record, notes);
  const std::vector<StereoFrame> frames = kept.from(guess.record.trajectory.front().t_ns);
  SmootherResult result = solve(recording, frames, guess, options, how, setup.calibration, told);
  if (!result.converged) {
    throw std::runtime_error(fmt::format("smooth: no solution after {} iterations", result.iterations));
  }
  count_cells(setup.calibration, result);
  RunRecord record = to_record(result, setup.calibration, how, length_sigma);
  record.recording_partial = recording.partial;
  record.frames_of_recording = frame_count(recording);
  notes.push_back(fmt::format("smoothed over {}, theta {}: {} iterations", frames_at_once(frames, options),
                              to_string(options.rig), result.iterations));
  notes.insert(notes.end(), record.notes.begin(), record.notes.end());
  record.notes = std::move(notes);
  record.cleaning = cleaner.report();
  const std::vector<std::string> removed = in_words(record.cleaning);
  record.notes.insert(record.notes.end(), removed.begin(), removed.end());
  record.start = guess.record.start;
  record.source_ms = guess.record.source_ms;
  const double source_ms = std::accumulate(record.source_ms.begin(), record.source_ms.end(), 0.0);
  const double spent_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  record.frame_ms.assign(frames.size(),
                         std::max(0.0, spent_ms - source_ms) / static_cast<double>(frames.size()));
  return record;
}

}  // namespace limber
