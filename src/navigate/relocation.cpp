// SPDX-License-Identifier: MIT
// StereoFilter's first frame after darkness: where in the map is the body?
#include <algorithm>
#include <cmath>

#include "limber/navigate/stereo_filter.hpp"
#include "stereo_pose.hpp"

namespace limber {

using L = StateLayout;

namespace {

/// At least: the stereo points that say it are used once more, and must not count twice.
constexpr double kLeastUnsure = 1.0;  // [m]
constexpr double kLeastTurn = 0.3;    // [rad]

double sigma_of(const Estimate& estimate, Eigen::Index at) {
  return std::sqrt(estimate.P().diagonal_block<kTriplet>(at).trace());
}

}  // namespace

/// The body where stereo points put it, by the rig as it is linearised or as it was given, and as unsure as
/// it was. @return whether they say
bool StereoFilter::relocate(const StereoFrame& frame, const MountedRig& rig) {
  auto there = detail::body_by_stereo(estimate_, frame, rig);
  if (!there) {
    there = detail::body_by_stereo(estimate_, frame, mounted(calibration_));
  }
  if (!there) {
    return false;
  }
  const double turn = std::max(kLeastTurn, sigma_of(estimate_, L::kAttitude));
  const bool has_velocity = options_.motion != MotionModel::kOdometry;
  const double velocity = has_velocity ? sigma_of(estimate_, L::kVelocity) +
                                             std::min(turn, 1.0) * estimate_.nav().v_world_body.norm()
                                       : 0.0;
  estimate_.place_body(*there, std::max(kLeastUnsure, sigma_of(estimate_, L::kPosition)), turn, velocity);
  return true;
}

/// From the prediction, or else from where stereo points put the body. Where neither ends with most points in
/// their places, those of before are taken for new ones if nobody knows how the body turned.
StereoFilter::Attempt StereoFilter::attempt_after_darkness(const StereoFrame& frame,
                                                           const LinearizationPoint& at,
                                                           const ParameterErrorModel& model,
                                                           FrameReport& report) {
  const Estimate predicted = estimate_;
  const FrameReport asked = report;
  Attempt out = attempt(frame, at, model, true, report);
  if (!out.lost) {
    return out;
  }
  estimate_ = predicted;
  report = asked;
  if (relocate(frame, at.rig)) {
    out = attempt(frame, choose_linearization_point(frame), model, true, report);
    if (!out.lost) {
      return out;
    }
    estimate_ = predicted;
    report = asked;
  }
  report.removed += forget_after_blindness(frame);
  return attempt(frame, choose_linearization_point(frame), model, true, report);
}

}  // namespace limber
