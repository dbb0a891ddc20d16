// SPDX-License-Identifier: MIT
#include "run/rig_windows.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

constexpr std::size_t kFewestWindows = 4, kFewestKeyframes = 6;
constexpr double kPriorAngle = 10.0 * M_PI / 180.0, kPriorShare = 1.0;
constexpr int kNoiseRounds = 4;
constexpr double kSameNoise = 0.1;  // of its logarithm

/// Root of the mean squared residual of the pixels, whitened.
double misfit_of_pixels(const SmootherResult& result) {
  double squares = 0.0, dof = -3.0 * static_cast<double>(result.landmarks.size());
  for (const SmoothedFrame& frame : result.frames) {
    squares += frame.squared_residuals;
    dof += static_cast<double>(frame.rows);
  }
  return squares > 0.0 && dof > 0.0 ? std::sqrt(squares / dof) : 1.0;
}

}  // namespace

std::vector<Keyframe> keyframes_of(const Guess& guess, KeptFrames& frames, double per_s) {
  std::map<std::int64_t, const NavigationState*> state_at;
  for (const NavigationState& state : guess.states) {
    state_at[state.t_ns] = &state;
  }
  std::vector<Keyframe> out;
  const auto interval_ns = static_cast<std::int64_t>(0.9e9 / per_s);
  for (StereoFrame& frame : frames.from(guess.record.trajectory.front().t_ns)) {
    const auto state = state_at.find(frame.t_ns);
    if (state != state_at.end() && (out.empty() || frame.t_ns - out.back().frame.t_ns >= interval_ns)) {
      out.push_back({std::move(frame), *state->second});
    }
  }
  return out;
}

std::vector<KeyframeWindow> windows_of(const std::vector<Keyframe>& keyframes,
                                       const RecalibrateOptions& options) {
  if (keyframes.size() < 2 * kFewestKeyframes) {
    throw std::runtime_error(fmt::format("recalibrate: expected at least {} keyframes, found {}",
                                         2 * kFewestKeyframes, keyframes.size()));
  }
  const std::int64_t begin = keyframes.front().frame.t_ns;
  const double duration_s = seconds_between(begin, keyframes.back().frame.t_ns);
  const auto wanted = static_cast<std::size_t>(duration_s / options.window_s);
  const std::size_t count = std::min(std::max(wanted, kFewestWindows), keyframes.size() / kFewestKeyframes);
  std::vector<KeyframeWindow> all(count);
  for (const Keyframe& keyframe : keyframes) {
    const double share = seconds_between(begin, keyframe.frame.t_ns) / duration_s;
    all[std::min(count - 1, static_cast<std::size_t>(share * static_cast<double>(count)))].push_back(
        keyframe);
  }
  std::erase_if(all, [](const KeyframeWindow& window) { return window.size() < kFewestKeyframes; });
  std::vector<KeyframeWindow> out;
  const std::size_t taken = std::min(all.size(), options.most_windows);
  for (std::size_t k = 0; k < taken; ++k) {
    out.push_back(std::move(all[k * all.size() / taken]));
  }
  return out;
}

bool moves(const KeyframeWindow& window, double baseline) {
  const Eigen::Vector3d& first = window.front().state.T_world_body.p;
  return std::any_of(window.begin(), window.end(), [&](const Keyframe& keyframe) {
    return (keyframe.state.T_world_body.p - first).norm() >= baseline;
  });
}

RigParameters vague_rig_sigma(double baseline) {
  RigParameters out;
  out << Eigen::Vector3d::Constant(kPriorAngle), Eigen::Vector3d::Constant(kPriorShare * baseline);
  return out;
}

SmootherResult smooth_window(const KeyframeWindow& window, const WindowInputs& inputs,
                             const StereoCalibration& given, const SmootherOptions& how) {
  std::vector<StereoFrame> frames;
  std::vector<NavigationState> states;
  for (const Keyframe& keyframe : window) {
    frames.push_back(keyframe.frame);
    states.push_back(keyframe.state);
  }
  SmootherResult result =
      smooth({frames, inputs.imu, inputs.odometry, states, detail::without_data(states.front(), how.motion)},
             given, how);
  if (!result.converged) {
    throw UnsolvableError(fmt::format("smoother: no solution after {} iterations", result.iterations));
  }
  return result;
}

RigPart rig_part(SmootherResult result, const StereoCalibration& given, const SmootherOptions& how) {
  const RigMatrix prior = how.rig_sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  RigPart out;
  out.from_ns = result.frames.front().nav.t_ns;
  out.to_ns = result.frames.back().nav.t_ns;
  const RigMatrix all = result.frames.front().theta_covariance.inverse();
  // Without the prior, which every window has seen.
  out.information = 0.5 * (all + all.transpose()) - prior;
  const SymmetricEigen eigen = symmetric_eigen(out.information);
  out.information = eigen.vectors * eigen.values.cwiseMax(0.0).asDiagonal() * eigen.vectors.transpose();
  const RigParameters step = result.frames.front().theta - given.theta;
  out.theta = given.theta + solve_symmetric(out.information, all * step);
  out.scores = std::move(result.theta_scores);
  return out;
}

double noise_in_residuals(const std::vector<KeyframeWindow>& windows, const WindowInputs& inputs,
                          const StereoCalibration& given, SmootherOptions how) {
  double factor = 1.0;
  for (const KeyframeWindow& window : windows) {
    try {
      for (int round = 0; round < kNoiseRounds; ++round) {  // what is refused depends on it
        const double more = misfit_of_pixels(smooth_window(window, inputs, given, how));
        factor *= more;
        how.sigma_px *= more;
        if (std::abs(std::log(more)) < kSameNoise) {
          break;
        }
      }
      return factor;
    } catch (const UnsolvableError&) {
      continue;  // said where it is left out
    }
  }
  return factor;
}

std::string left_out(const KeyframeWindow& window, std::int64_t begin_ns, const UnsolvableError& why) {
  return fmt::format("window of {:.1f} to {:.1f} s left out: {}",
                     seconds_between(begin_ns, window.front().frame.t_ns),
                     seconds_between(begin_ns, window.back().frame.t_ns), why.what());
}

}  // namespace limber::detail
