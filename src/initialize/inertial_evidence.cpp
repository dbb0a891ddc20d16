// SPDX-License-Identifier: MIT
#include "limber/initialize/inertial_evidence.hpp"

#include <array>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "inertial_offsets.hpp"
#include "start_window.hpp"
#include "window_pixels.hpp"

namespace limber {

using namespace detail;
using Eigen::MatrixXd;

namespace {

constexpr int kShownSteps = 6;  // of a solution, from one that is near
/// [m/s^2]: of cheap accelerometers, whose axes and scales were blamed for it.
constexpr double kAnyBias = 0.6;

/// The method that takes nothing of the rig for granted.
NavigatorOptions doubting_rig(NavigatorOptions options) {
  options.method = Method::kLcekf;
  options.constraints = default_constraints(options.motion);
  options.learn_imu_noise = false;
  return options;
}

/// The first frame stands at the origin, as a window has it.
WindowState from_origin(const StartWindow::Frames& now, std::span<const StereoFrame> frames,
                        std::span<const NavigationState> states) {
  WindowState out{now.frames, {}};
  std::size_t n = 0;
  for (std::size_t k = 0; k < out.frames.size(); ++k) {
    while (frames[n].t_ns != now.raw[k].t_ns) {
      ++n;
    }
    out.frames[k].nav = states[n];
    out.frames[k].nav.T_world_body.p -= states.front().T_world_body.p;
    out.frames[k].nav.t_ns = now.raw[k].t_ns;
  }
  return out;
}

/// The same frames, every other one or fewer, so that the first stays.
StartWindow window_of(const NavigatorOptions& options, const StereoCalibration& calibration,
                      std::span<const StereoFrame> frames, std::span<const ImuSample> imu) {
  StartWindow out(doubting_rig(options), calibration, {});
  auto sample = imu.begin();
  for (const StereoFrame& frame : frames) {
    for (; sample != imu.end() && (sample == imu.begin() || (sample - 1)->t_ns < frame.t_ns); ++sample) {
      out.add_by_clock({sample->t_ns, sample->omega_imu, sample->accel_imu});
    }
    (void)out.push(frame);
  }
  return out;
}

}  // namespace

std::string_view to_string(InertialFactor factor) {
  constexpr std::array<std::string_view, 7> kNames = {
      "mount",      "lever arm", "accelerometer scale", "accelerometer axes",
      "gyro scale", "clock",     "accelerometer scales"};
  return kNames[static_cast<std::size_t>(factor)];
}

MatrixXd directions_of(InertialFactor factor) {
  const OffsetPlace at = place_of(factor);
  MatrixXd each = MatrixXd::Zero(InertialEvidence::kOffsets, at.size);
  each.middleRows(at.first, at.size).setIdentity();
  return factor == InertialFactor::kAccelScale ? MatrixXd(each.rowwise().sum()) : each;
}

InertialEvidence& InertialEvidence::operator+=(const InertialEvidence& other) {
  information += other.information;
  score += other.score;
  misfit += other.misfit;
  dof += other.dof;
  return *this;
}

InertialEvidence& InertialEvidence::operator-=(const InertialEvidence& other) {
  information -= other.information;
  score -= other.score;
  misfit -= other.misfit;
  dof -= other.dof;
  return *this;
}

std::optional<InertialEvidence> inertial_evidence(const NavigatorOptions& options,
                                                  const StereoCalibration& calibration,
                                                  std::span<const StereoFrame> frames,
                                                  std::span<const ImuSample> imu,
                                                  std::span<const NavigationState> states) {
  if (states.size() != frames.size()) {
    throw std::invalid_argument("inertial evidence: expected a state for each frame");
  }
  if (options.motion != MotionModel::kImu || frames.size() < InertialEvidence::kFewestFrames ||
      imu.size() < 2) {
    return std::nullopt;
  }
  StartWindow window = window_of(options, calibration, frames, imu);
  window.model.prior.bias_accel = kAnyBias;
  const StartWindow::Frames now = window.kept();
  (void)window.try_guess(window.continued(from_origin(now, frames, states), now));
  if (!window.solution) {
    return std::nullopt;
  }
  window.clean_and_cover();
  if (!window.solution || window.normal.left > kSettled) {
    return std::nullopt;
  }
  const WindowModel shown = with_shown_pixels(window.model, *window.solution);
  const WindowNormal normal = solve_window(shown, *window.solution, kShownSteps);
  const MatrixXd covariance = frame_covariance(normal);
  if (covariance.size() == 0 || normal.left > kSettled) {
    return std::nullopt;
  }
  return evidence_of(shown, *window.solution, normal, covariance);
}

}  // namespace limber
