// SPDX-License-Identifier: MIT
// What a start owes to parameters beyond theta that are not known exactly: docs/derivations/start.md.
#include "window_parameters.hpp"

#include <cstdint>
#include <unordered_map>

#include "limber/core/so3.hpp"
#include "limber/sensors/parameters.hpp"

namespace limber::detail {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr int kIterations = 10;

/// A point as the last left camera of `model` would see it, in the chart of a landmark that is handed over;
/// nothing behind it. The body is where the point is told from: the mount that was assumed for it is its own
/// affair.
std::optional<Vector3d> in_chart(const WindowModel& model, const ShiftedSolution& shifted,
                                 const WindowPoint& point, const Landmark& handed) {
  const Pose T_cam0_body = mount(model.calibration)[0].T_cam_body;
  const Anchor anchor{shifted.state.frames[point.anchor()].nav.T_world_body,
                      mount(shifted.model.calibration)[0].T_cam_body.inverse()};
  const BodyPoint in_body = body_point(shifted.state.frames.back().nav.T_world_body, point.landmark, &anchor);
  const Vector3d X =
      handed.R_cam0_chart.transpose() * (T_cam0_body.R * in_body.Y + in_body.w * T_cam0_body.p);
  return X.z() > 0.0 ? std::optional(Vector3d(X.x() / X.z(), X.y() / X.z(), in_body.w / X.z()))
                     : std::nullopt;
}

}  // namespace

VectorXd by_one(const ShiftedSolution& shifted, const WindowModel& model, const InitialState& initial) {
  std::unordered_map<std::int64_t, const WindowPoint*> points;
  for (const WindowPoint& point : shifted.state.points) {
    points[point.landmark.track_id] = &point;
  }
  const Index body = initial.body_covariance.rows();
  VectorXd out = VectorXd::Zero(body + 3 * static_cast<Index>(initial.landmarks.size()));
  out.head(body) = body_error(model.options.motion, initial.nav, shifted.state.frames.back().nav);
  for (std::size_t j = 0; j < initial.landmarks.size(); ++j) {
    const Landmark& handed = initial.landmarks[j];
    if (const auto value = in_chart(model, shifted, *points.at(handed.track_id), handed)) {
      out.segment<3>(body + 3 * static_cast<Index>(j)) = *value - handed.value;
    }
  }
  return out / shifted.sigma;
}

std::vector<ShiftedSolution> shifted_solutions(const WindowModel& model, const WindowState& state) {
  std::vector<ShiftedSolution> out;
  for (Index k = kBlockSize; k < kParameters; ++k) {
    const double sigma = model.options.estimated(k);
    if (sigma == 0.0) {
      continue;
    }
    ShiftedSolution shifted{k, sigma, model, state};
    shifted.model.calibration = corrected(model.calibration, sigma * ParameterVector::Unit(k));
    (void)solve_window(shifted.model, shifted.state, kIterations);
    out.push_back(std::move(shifted));
  }
  return out;
}

VectorXd body_error(MotionModel motion, const NavigationState& from, const NavigationState& to) {
  using L = StateLayout;
  VectorXd out = VectorXd::Zero(L{motion}.body_size());
  out.segment<3>(L::kPosition) = to.T_world_body.p - from.T_world_body.p;
  out.segment<3>(L::kAttitude) = so3_log(from.T_world_body.R.transpose() * to.T_world_body.R);
  if (motion != MotionModel::kOdometry) {
    out.segment<3>(L::kVelocity) = to.v_world_body - from.v_world_body;
  }
  if (motion == MotionModel::kConstantVelocity) {
    out.segment<3>(L::kRate) = to.omega_body - from.omega_body;
  }
  if (motion == MotionModel::kImu) {
    out.segment<3>(L::kBiasGyro) = to.bias_gyro - from.bias_gyro;
    out.segment<3>(L::kBiasAccel) = to.bias_accel - from.bias_accel;
  }
  return out;
}

MatrixXd by_parameters(const std::vector<ShiftedSolution>& shifted, const WindowModel& model,
                       const InitialState& initial) {
  if (shifted.empty()) {
    return {};
  }
  MatrixXd out = MatrixXd::Zero(
      initial.body_covariance.rows() + 3 * static_cast<Index>(initial.landmarks.size()), kMoreParameters);
  for (const ShiftedSolution& one : shifted) {
    out.col(one.parameter - kBlockSize) = by_one(one, model, initial);
  }
  return out;
}

}  // namespace limber::detail
