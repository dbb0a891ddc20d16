// SPDX-License-Identifier: MIT
#include "limber/run/recalibrate_recording.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "limber/clean/frame_cleaner.hpp"
#include "limber/core/factors.hpp"
#include "limber/core/time.hpp"
#include "limber/measure/epipolar.hpp"
#include "limber/measure/triangulate.hpp"
#include "limber/smooth/unsolvable_error.hpp"
#include "run/rig_windows.hpp"
#include "run/smooth_setup.hpp"
#include "run/window_record.hpp"

namespace limber {
namespace {

using detail::Guess, detail::KeptFrames, detail::Keyframe, detail::KeyframeWindow;

/// Beside what the windows show: accepted calibrations of one rig differ by 0.10 to 0.15 px and up to 4 % of
/// depth at 90 baselines, by lens models that are wrong in the same way all the time. Standard deviations.
constexpr double kLens_px = 0.1, kLensDepth = 0.02;
constexpr double kHeldOutShare = 0.25;  // of the misfit may be left by a rig that is right
constexpr double kTwoSided = 1.96;      // of a normal distribution: 95 %
constexpr double kClip_px = 5.0;        // beyond, a point is a mismatch
constexpr double kStep = 1e-6;          // of numerical derivatives [rad, m]
constexpr std::array kDepths = {5.0, 10.0, 20.0};
constexpr std::size_t kShareOfFilter = 40;  // [%] of the work

double clipped(double px) { return std::clamp(px, -kClip_px, kClip_px); }

/// What the points of the keyframes say of both rigs, and of the change between them.
void compare_epipolar(const std::vector<Keyframe>& keyframes, Recalibration& out) {
  const double focal = out.given.cam1.fu;
  double given = 0.0, fitted = 0.0, change = 0.0, count = 0.0;
  RigMatrix slope2 = RigMatrix::Zero();
  const Pose T_given = pose_from_rig(out.given.theta), T_fitted = pose_from_rig(out.fitted.theta);
  const RigMatrix by_theta = detail::pose_by_theta(out.fitted.theta);
  for (const Keyframe& keyframe : keyframes) {
    for (const StereoObservation& o : keyframe.frame.observations) {
      const auto pair = detail::bearings(out.given, o);
      if (!pair) {
        continue;
      }
      const double before = focal * detail::epipolar_error(*pair, T_given);
      const double after = focal * detail::epipolar_error(*pair, T_fitted);
      if (std::abs(after) > kClip_px && std::abs(before) > kClip_px) {
        continue;
      }
      const RigParameters slope = focal * (detail::epipolar_slope(*pair, T_fitted) * by_theta).transpose();
      slope2 += slope * slope.transpose();
      given += before * before;
      fitted += clipped(after) * clipped(after);
      change += (after - before) * (after - before);
      count += 1.0;
    }
  }
  if (count > 0.0) {
    out.epipolar_px = {std::sqrt(given / count), std::sqrt(fitted / count)};
    out.epipolar_change_px = std::sqrt(change / count);
    out.epipolar_sigma_px = std::sqrt((slope2 * out.fit.covariance).trace() / count);
  }
}

/// Measured over true depth less one, straight ahead.
double depth_share(const RigParameters& assumed, const RigParameters& truth, double depth) {
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d seen = pose_from_rig(truth) * Eigen::Vector3d(depth * ahead);
  const auto rho = inverse_depth_along(ahead, seen.normalized(), pose_from_rig(assumed));
  return rho && *rho > 0.0 ? 1.0 / (*rho * depth) - 1.0 : std::numeric_limits<double>::infinity();
}

DepthChange depth_change(const Recalibration& found, double depth) {
  DepthChange out{depth, depth_share(found.given.theta, found.fitted.theta, depth), 0.0};
  RigParameters slope;
  for (Eigen::Index k = 0; k < 6; ++k) {
    const RigParameters step = kStep * RigParameters::Unit(k);
    slope(k) = (depth_share(found.fitted.theta, found.fitted.theta + step, depth) -
                depth_share(found.fitted.theta, found.fitted.theta - step, depth)) /
               (2.0 * kStep);
  }
  out.sigma = std::sqrt(std::max(0.0, slope.dot(found.fit.covariance * slope)));
  return out;
}

/// Those in which the camera moves: without motion nothing tells lengths from depths.
std::vector<KeyframeWindow> moving_windows(const std::vector<Keyframe>& keyframes,
                                           const RecalibrateOptions& options, Recalibration& out) {
  const double baseline = out.given.baseline();
  std::vector<KeyframeWindow> windows = detail::windows_of(keyframes, options);
  const std::size_t still =
      std::erase_if(windows, [&](const KeyframeWindow& window) { return !detail::moves(window, baseline); });
  if (still > 0) {
    out.notes.push_back(
        fmt::format("{} of {} windows left out: the camera moved by less than a baseline ({:.3g} m)", still,
                    still + windows.size(), baseline));
  }
  return windows;
}

/// What the filter learned of inputs and pixels; of the latter, what the smoother leaves of them.
void take_noise(const RunRecord& learned, const std::vector<KeyframeWindow>& windows,
                const detail::WindowInputs& inputs, SmootherOptions& how, Recalibration& out) {
  detail::take_imu_noise(learned.imu_noise, how, out.notes);
  detail::say_clock(learned, out.notes);
  if (learned.pixel_noise && !windows.empty()) {
    how.sigma_px.setConstant(learned.pixel_noise->sigma_px);
    how.sigma_px *= detail::noise_in_residuals(windows, inputs, out.given, how);
    out.notes.push_back(fmt::format("pixel noise by what the smoother leaves: {:.2g} px", how.sigma_px(0)));
  }
}

/// What each window says of the rig. @param told  how many are done
void solve_windows(const std::vector<KeyframeWindow>& windows, const detail::WindowInputs& inputs,
                   const SmootherOptions& how, std::int64_t begin_ns,
                   const std::function<void(std::size_t)>& told, Recalibration& out) {
  for (std::size_t k = 0; k < windows.size(); ++k) {
    told(k);
    try {
      out.windows.push_back(
          detail::rig_part(detail::smooth_window(windows[k], inputs, out.given, how), out.given, how));
      out.keyframes += windows[k].size();
    } catch (const UnsolvableError& error) {
      out.notes.push_back(detail::left_out(windows[k], begin_ns, error));
    }
  }
  if (out.windows.empty() && !windows.empty()) {
    throw UnsolvableError("recalibrate: no part of the recording could be solved; " + out.notes.back());
  }
}

/// The rig of all windows, and whether it is better in those that it was not fitted to.
/// @param odometry_scale  relative standard deviation, which all lengths share
void fit_to_windows(const RecalibrateOptions& options, double odometry_scale, Recalibration& out) {
  RigParameters bounds;
  bounds << Eigen::Vector3d::Constant(options.seen_angle),
      Eigen::Vector3d::Constant(options.seen_share * out.given.baseline());
  out.fit.theta = out.given.theta;
  out.fit.covariance = bounds.cwiseAbs2().asDiagonal();
  if (out.windows.empty()) {
    return;
  }
  out.fit = fit_rig(out.windows, out.given.theta, bounds);
  out.fitted.theta = out.fit.theta;
  const Eigen::Vector3d by_scale = odometry_scale * out.fitted.theta.tail<3>();
  out.fit.covariance.bottomRightCorner<3, 3>() += by_scale * by_scale.transpose();
  out.held_out = held_out(out.windows, out.given.theta, bounds);
}

RecalibrationVerdict judge(const Recalibration& found, const RecalibrateOptions& options) {
  const double px = found.epipolar_change_px, depth = std::abs(found.at_tolerance.share);
  // The tolerance has room for what lens models do; what is called wrong has to be so in spite of them.
  const double px_sigma = std::hypot(found.epipolar_sigma_px, kLens_px),
               depth_sigma = std::hypot(found.at_tolerance.sigma, kLensDepth);
  if (found.fit.seen.none() || found.windows.size() < 2) {
    return RecalibrationVerdict::kCannotTell;
  }
  const bool outside = px - kTwoSided * px_sigma > options.tolerance_px ||
                       depth - kTwoSided * depth_sigma > options.tolerance_depth;
  if (!outside) {
    const bool inside = px + kTwoSided * found.epipolar_sigma_px <= options.tolerance_px &&
                        depth + kTwoSided * found.at_tolerance.sigma <= options.tolerance_depth;
    return inside ? RecalibrationVerdict::kWithinTolerance : RecalibrationVerdict::kCannotTell;
  }
  const bool better = found.held_out.fitted < kHeldOutShare * found.held_out.given &&
                      found.epipolar_px.fitted <= found.epipolar_px.given;
  return better ? RecalibrationVerdict::kBetter : RecalibrationVerdict::kNotBetter;
}

}  // namespace

std::string to_string(RecalibrationVerdict verdict) {
  switch (verdict) {
    case RecalibrationVerdict::kBetter:
      return "better";
    case RecalibrationVerdict::kWithinTolerance:
      return "within tolerance";
    case RecalibrationVerdict::kNotBetter:
      return "not better";
    case RecalibrationVerdict::kCannotTell:
      break;
  }
  return "cannot tell";
}

Recalibration recalibrate_recording(const Recording& recording, const RecalibrateOptions& options,
                                    const FrameSource& source,
                                    const std::function<void(std::size_t)>& progress) {
  const auto told = [&](std::size_t share) {
    if (progress) {
      progress(share);
    }
  };
  SmoothOptions smooth_options;
  smooth_options.run = options.run;
  smooth_options.run.cleaning.max_points = std::min(options.points, options.run.cleaning.max_points);
  smooth_options.rig = RigModel::kConstant;
  smooth_options.threads = options.threads;
  const RunSetup setup = set_up_run(recording, smooth_options.run);
  Recalibration out;
  out.notes = setup.notes;
  out.given = out.fitted = setup.calibration;
  SmootherOptions how = detail::smoother_options(recording, smooth_options, setup, out.notes);
  how.rig_sigma = detail::vague_rig_sigma(out.given.baseline());
  out.length_seen = !how.trust_length;

  FrameCleaner cleaner(setup.calibration, smooth_options.run.cleaning);
  const FrameSource cleaned = [&](std::size_t n) { return cleaner.clean(source(n)); };
  KeptFrames kept(cleaned);
  const std::size_t frames = std::max<std::size_t>(1, frame_count(recording));
  const Guess guess = detail::guess_by(Method::kLcekf, recording, smooth_options.run, kept,
                                       [&](std::size_t n) { told(kShareOfFilter * n / frames); });
  const std::vector<Keyframe> keyframes = detail::keyframes_of(guess, kept, options.keyframes_per_s);
  const std::vector<KeyframeWindow> windows = moving_windows(keyframes, options, out);
  const detail::WindowInputs inputs{guess.imu, recording.odometry};
  take_noise(guess.record, windows, inputs, how, out);
  const std::int64_t begin_ns = keyframes.empty() ? 0 : keyframes.front().frame.t_ns;
  const auto told_windows = [&](std::size_t done) {
    told(kShareOfFilter + (100 - kShareOfFilter) * done / windows.size());
  };
  solve_windows(windows, inputs, how, begin_ns, told_windows, out);
  fit_to_windows(options, setup.navigator.odometry_scale, out);
  compare_epipolar(keyframes, out);
  for (const double depth : kDepths) {
    out.depths.push_back(depth_change(out, depth));
  }
  out.at_tolerance = depth_change(out, options.baselines * out.given.baseline());
  out.verdict = judge(out, options);
  told(100);
  return out;
}

}  // namespace limber
