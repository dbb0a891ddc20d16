// SPDX-License-Identifier: MIT
#include "run_observer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "limber/core/divergence_error.hpp"
#include "limber/core/time.hpp"
#include "limber/datasets/interpolate.hpp"
#include "limber/diagnose/run_summary.hpp"
#include "limber/evaluate/consistency.hpp"
#include "limber/study/exact_sum.hpp"

namespace limber::detail {
namespace {

/// A point that seems further away than this many times the cameras' range has no place yet, only a
/// direction.
constexpr double kPlacelessRanges = 10.0;

Pose true_pose(const Recording& recording, std::int64_t t_ns) {
  const GroundTruthState truth = *groundtruth_at(recording.truth.motion.states, t_ns);
  return {truth.R_world_body, truth.p_world_body};
}

}  // namespace

RunObserver::RunObserver(const Recording& recording, const Scenario& scenario, StartMode start)
    : recording_(recording), scenario_(scenario), start_(start), slots_(frame_times(scenario).size()) {}

std::size_t RunObserver::slot_of(std::int64_t t_ns) const {
  return static_cast<std::size_t>(std::llround(to_seconds(t_ns) * scenario_.stereo_rate));
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

void RunObserver::observe(const ObservedFrame& frame) {
  frame_.clear();
  observe_pose(frame.row);
  if (frame.navigator != nullptr) {
    observe_map(*frame.navigator);
    if (frame.navigator->estimate().layout().has_theta) {
      observe_theta(*frame.navigator);
    }
  }
  const std::size_t slot = slot_of(frame.row.t_ns);
  for (const auto& [quantity, value] : frame_) {
    std::vector<double>& values = series_[quantity];
    values.resize(slots_, std::numeric_limits<double>::quiet_NaN());
    values.at(slot) = value;
  }
  positions_.push_back((*alignment_ * frame.row.T_world_body).p);
  ++observed_;
}

void RunObserver::align(const TrajectoryRow& first) {
  const MatchedPose pose{first.t_ns, 0, first.T_world_body, true_pose(recording_, first.t_ns)};
  alignment_ = start_alignment({&pose, 1}, start_,
                               scenario_.use_imu ? MotionModel::kImu : MotionModel::kConstantVelocity)
                   .alignment;
}

void RunObserver::observe_pose(const TrajectoryRow& row) {
  if (!alignment_) {
    align(row);
  }
  const PoseErrorVector error = pose_error(*alignment_ * row.T_world_body, true_pose(recording_, row.t_ns));
  const PoseCovariance P = turned(*row.covariance, alignment_->T_true_est.R);
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
    const auto known = recording_.truth.landmarks.find(landmark.track_id);
    const bool moves = known == recording_.truth.landmarks.end();
    if (moves || (landmark.kind == LandmarkKind::kInverseDepth && landmark.value.z() * farthest < 1.0)) {
      continue;
    }
    map_error_.mean_squared += (alignment_->T_true_est * positions[k] - known->second).squaredNorm();
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
  const RigParameters theta_true = true_rig_at(recording_.truth.rig, estimate.nav().t_ns).theta;
  const Eigen::Matrix<double, 6, 6> P = estimate.P().diagonal_block<6>(estimate.layout().theta());
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const auto k = static_cast<Eigen::Index>(axis);
    const double error = estimate.theta()(k) - theta_true(k);
    set(theta_axis(CurveQuantity::kDeltaAx, axis), estimate.theta()(k) - recording_.calibration.theta(k));
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
