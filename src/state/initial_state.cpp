// SPDX-License-Identifier: MIT
#include "limber/state/initial_state.hpp"

namespace limber {

using L = StateLayout;

InitialState make_initial_state(const NavigationState& nav, MotionModel motion, const InitialSigma& sigma) {
  const Eigen::Index n = StateLayout{motion}.body_size();
  Eigen::VectorXd s(n);
  s.segment<3>(L::kPosition).setConstant(sigma.position);
  s.segment<3>(L::kAttitude).setConstant(sigma.attitude);
  if (motion != MotionModel::kOdometry) {
    s.segment<3>(L::kVelocity).setConstant(sigma.velocity);
  }
  if (motion == MotionModel::kConstantVelocity) {
    s.segment<3>(L::kRate).setConstant(sigma.rate);
  }
  if (motion == MotionModel::kImu) {
    s.segment<3>(L::kBiasGyro).setConstant(sigma.bias_gyro);
    s.segment<3>(L::kBiasAccel).setConstant(sigma.bias_accel);
  }
  return {nav, s.cwiseAbs2().asDiagonal()};
}

}  // namespace limber
