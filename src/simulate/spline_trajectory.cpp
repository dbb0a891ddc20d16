// SPDX-License-Identifier: MIT
#include "limber/simulate/spline_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "limber/core/so3.hpp"

namespace limber {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Cumulative blending functions of the cubic B-spline at u in [0, 1], and their derivatives by time.
struct Blending {
  Vector3d value, first, second;
};

Blending blending(double u, double spacing) {
  Blending b;
  b.value =
      Vector3d(5.0 + u * (3.0 + u * (-3.0 + u)), 1.0 + u * (3.0 + u * (3.0 - 2.0 * u)), u * u * u) / 6.0;
  b.first = Vector3d(3.0 + u * (-6.0 + 3.0 * u), 3.0 + u * (6.0 - 6.0 * u), 3.0 * u * u) / (6.0 * spacing);
  b.second = Vector3d(-1.0 + u, 1.0 - 2.0 * u, u) / (spacing * spacing);
  return b;
}

}  // namespace

Vector3d specific_force(const Kinematics& state, double gravity) {
  return state.T_world_body.R.transpose() * (state.a_world_body + gravity * Vector3d::UnitZ());
}

SplineTrajectory::SplineTrajectory(std::vector<Pose> control_poses, double knot_spacing, double rest)
    : control_poses_(std::move(control_poses)), knot_spacing_(knot_spacing), rest_(rest) {
  if (control_poses_.size() < 4) {
    throw std::invalid_argument("SplineTrajectory: needs at least 4 control poses, got " +
                                std::to_string(control_poses_.size()));
  }
  if (!(knot_spacing_ > 0.0) || !std::isfinite(knot_spacing_)) {
    throw std::invalid_argument("SplineTrajectory: the knot spacing must be positive");
  }
  if (!(rest_ >= 0.0) || !std::isfinite(rest_)) {
    throw std::invalid_argument("SplineTrajectory: the rest must not be negative");
  }
  for (std::size_t i = 0; i + 1 < control_poses_.size(); ++i) {
    rotation_steps_.push_back(so3_log(control_poses_[i].R.transpose() * control_poses_[i + 1].R));
  }
}

double SplineTrajectory::duration() const {
  return rest_ + knot_spacing_ * static_cast<double>(control_poses_.size() - 3);
}

Kinematics SplineTrajectory::at(double t) const {
  if (!(t >= 0.0 && t <= duration())) {
    throw std::invalid_argument("SplineTrajectory: t = " + std::to_string(t) + " s is outside [0, " +
                                std::to_string(duration()) + "] s");
  }
  const std::size_t last_segment = control_poses_.size() - 4;
  const double knots = std::max(t - rest_, 0.0) / knot_spacing_;
  const std::size_t i = std::min(static_cast<std::size_t>(knots), last_segment);
  const Blending b = blending(knots - static_cast<double>(i), knot_spacing_);

  Kinematics state;
  state.T_world_body = control_poses_[i];
  for (int k = 0; k < 3; ++k) {
    const std::size_t from = i + static_cast<std::size_t>(k);
    const Vector3d step = control_poses_[from + 1].p - control_poses_[from].p;
    state.T_world_body.p += b.value[k] * step;
    state.v_world_body += b.first[k] * step;
    state.a_world_body += b.second[k] * step;

    const Vector3d& turn = rotation_steps_[from];
    const Matrix3d A = so3_exp(b.value[k] * turn);
    state.T_world_body.R = state.T_world_body.R * A;
    state.omega_body = A.transpose() * state.omega_body + b.first[k] * turn;  // recursion of [Sommer2020]
  }
  state.T_world_body.R = so3_normalized(state.T_world_body.R);
  return state;
}

}  // namespace limber
