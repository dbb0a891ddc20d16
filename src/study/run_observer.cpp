// SPDX-License-Identifier: MIT
#include "run_observer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "limber/core/divergence_error.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/evaluate/consistency.hpp"
#include "limber/study/exact_sum.hpp"

namespace limber::detail {
namespace {

/// A point that seems further away than this many times the cameras' range has no place yet, only a
/// direction.
constexpr double kPlacelessRanges = 10.0;

PoseCovariance pose_covariance(const Navigator& navigator) {
  return navigator.estimate().P.diagonal_block<StateLayout::kPoseSize>(0);
}

}  // namespace

RunObserver::RunObserver(const Recording& recording, const Scenario& scenario)
    : recording_(recording), scenario_(scenario), slots_(frame_times(scenario).size()) {}

std::size_t RunObserver::slot_of(std::int64_t t_ns) const {
  return static_cast<std::size_t>(std::llround(1e-9 * static_cast<double>(t_ns) * scenario_.stereo_rate));
}

Divergence RunObserver::divergence(const std::string& reason) const {
  const std::size_t n = std::min(observed_, recording_.frames.size() - 1);
  const std::int64_t t_ns = recording_.frames[n].t_ns;
  return {slot_of(t_ns), static_cast<double>(t_ns) / 1e9, reason};
}

void RunObserver::set(CurveQuantity quantity, double value) {
  if (!std::isnan(value) && !to_fixed(value, fraction_bits(quantity))) {
    throw DivergenceError(fmt::format("{} is {:.3g}", name_of(quantity), value));
  }
  frame_[quantity] = value;
}

void RunObserver::observe(const Navigator& navigator) {
  frame_.clear();
  observe_pose(navigator);
  observe_map(navigator);
  if (navigator.estimate().layout().has_theta) {
    observe_theta(navigator);
  }
  const std::size_t slot = slot_of(navigator.estimate().nav.t_ns);
  for (const auto& [quantity, value] : frame_) {
    std::vector<double>& values = series_[quantity];
    values.resize(slots_, std::numeric_limits<double>::quiet_NaN());
    values.at(slot) = value;
  }
  positions_.push_back(navigator.estimate().nav.T_world_body.p);
  ++observed_;
}

void RunObserver::observe_pose(const Navigator& navigator) {
  const NavigationState& nav = navigator.estimate().nav;
  const GroundTruthState truth = *groundtruth_at(recording_.groundtruth, nav.t_ns);
  const PoseErrorVector error = pose_error(nav.T_world_body, {truth.R_world_body, truth.p_world_body});
  const PoseCovariance P = pose_covariance(navigator);
  if (!error.allFinite() || !P.allFinite() || P.diagonal().minCoeff() < 0.0) {
    throw DivergenceError("the pose or its covariance is not finite, or a variance is negative");
  }
  if (error.head<3>().norm() > kAbsurdPositionError) {
    throw DivergenceError(fmt::format("the position is {:.3g} m off", error.head<3>().norm()));
  }
  set(CurveQuantity::kPositionSquaredError, error.head<3>().squaredNorm());
  set(CurveQuantity::kPositionVariance, P.diagonal().head<3>().sum());
  set(CurveQuantity::kAttitudeSquaredError, error.tail<3>().squaredNorm());
  set(CurveQuantity::kAttitudeVariance, P.diagonal().tail<3>().sum());
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  const PoseNees nees = pose_nees(error, P).value_or(PoseNees{kNothing, kNothing, kNothing});
  set(CurveQuantity::kPoseNees, nees.pose);
  set(CurveQuantity::kPositionNees, nees.position);
  set(CurveQuantity::kAttitudeNees, nees.attitude);
}

void RunObserver::observe_map(const Navigator& navigator) {
  const Estimate& estimate = navigator.estimate();
  const double farthest = kPlacelessRanges * scenario_.world.max_range;
  map_error_ = {};
  const std::vector<Eigen::Vector3d> positions = estimate.landmark_positions();
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const Landmark& landmark = estimate.landmarks()[k];
    if (landmark.kind == LandmarkKind::kInverseDepth && landmark.value.z() * farthest < 1.0) {
      continue;
    }
    map_error_.mean_squared += (positions[k] - recording_.landmarks_true.at(landmark.track_id)).squaredNorm();
    ++map_error_.points;
  }
  if (map_error_.points > 0) {
    map_error_.mean_squared /= static_cast<double>(map_error_.points);
    set(CurveQuantity::kLandmarkSquaredError, map_error_.mean_squared);
  }
  set(CurveQuantity::kLandmarks, static_cast<double>(map_error_.points));
}

void RunObserver::observe_theta(const Navigator& navigator) {
  const Estimate& estimate = navigator.estimate();
  const RigParameters theta_true = calibration_at(recording_.calibration_true, estimate.nav.t_ns);
  const Eigen::Matrix<double, 6, 6> P = estimate.P.diagonal_block<6>(estimate.layout().theta());
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    const double error = estimate.theta(k) - theta_true(k);
    set(theta_axis(CurveQuantity::kDeltaAx, axis), estimate.theta(k) - recording_.calibration.theta(k));
    set(theta_axis(CurveQuantity::kThetaSquaredErrorAx, axis), error * error);
    set(theta_axis(CurveQuantity::kThetaVarianceAx, axis), P(k, k));
  }
}

std::vector<RunSeries> RunObserver::take_series() {
  std::vector<RunSeries> out;
  for (auto& [quantity, values] : series_) {
    out.push_back({quantity, std::move(values)});
  }
  series_.clear();
  return out;
}

}  // namespace limber::detail
