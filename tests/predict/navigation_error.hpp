// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "limber/core/so3.hpp"
#include "limber/state/state.hpp"
#include "random_geometry.hpp"

/// The body's error state, written out a second time: true = estimate ⊕ error.
namespace limber::testing {

inline NavigationState retracted(NavigationState state, MotionModel motion, const Eigen::VectorXd& dx) {
  state.T_world_body.p += dx.segment<3>(0);
  state.T_world_body.R = state.T_world_body.R * so3_exp(dx.segment<3>(3));
  if (motion == MotionModel::kImu) {
    state.v_world_body += dx.segment<3>(6);
    state.bias_gyro += dx.segment<3>(9);
    state.bias_accel += dx.segment<3>(12);
  } else if (motion == MotionModel::kConstantVelocity) {
    state.v_world_body += dx.segment<3>(6);
    state.omega_body += dx.segment<3>(9);
  }
  return state;
}

/// The dx with state = reference ⊕ dx.
inline Eigen::VectorXd error_between(const NavigationState& state, const NavigationState& reference,
                                     MotionModel motion) {
  Eigen::VectorXd dx(StateLayout{motion, false}.body_size());
  dx.segment<3>(0) = state.T_world_body.p - reference.T_world_body.p;
  dx.segment<3>(3) = so3_log(reference.T_world_body.R.transpose() * state.T_world_body.R);
  if (motion == MotionModel::kImu) {
    dx.segment<3>(6) = state.v_world_body - reference.v_world_body;
    dx.segment<3>(9) = state.bias_gyro - reference.bias_gyro;
    dx.segment<3>(12) = state.bias_accel - reference.bias_accel;
  } else if (motion == MotionModel::kConstantVelocity) {
    dx.segment<3>(6) = state.v_world_body - reference.v_world_body;
    dx.segment<3>(9) = state.omega_body - reference.omega_body;
  }
  return dx;
}

inline NavigationState random_navigation_state(Generator& generator) {
  NavigationState state;
  state.T_world_body = random_pose(generator, 10.0);
  state.v_world_body = random_vector(generator, 5.0);
  state.omega_body = random_vector(generator, 2.0);
  state.bias_gyro = random_vector(generator, 0.1);
  state.bias_accel = random_vector(generator, 0.5);
  return state;
}

}  // namespace limber::testing
