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

void place_first_map(Estimate& estimate, const InitialState& initial, const Pose& T_body_cam0) {
  using Eigen::Index;
  using Eigen::MatrixXd;
  if (initial.landmarks.empty()) {
    return;
  }
  const Index body = estimate.layout().body_size();
  const Index clone = estimate.size();
  const int anchor = estimate.add_anchor(T_body_cam0);
  const Index map = estimate.size();
  for (std::size_t j = 0; j < initial.landmarks.size(); ++j) {
    const auto at = static_cast<Index>(kTriplet * static_cast<Index>(j));
    MatrixXd P_xl = MatrixXd::Zero(estimate.size(), kTriplet);
    P_xl.topRows(body) = initial.landmarks_body.middleRows<kTriplet>(at).transpose();
    P_xl.middleRows<L::kPoseSize>(clone) = P_xl.topRows<L::kPoseSize>();
    P_xl.middleRows(map, at) = initial.landmarks_covariance.block(0, at, at, kTriplet);
    Landmark landmark = initial.landmarks[j];
    landmark.anchor = anchor;
    estimate.add_landmark(landmark, initial.landmarks_covariance.block<kTriplet, kTriplet>(at, at), P_xl);
  }
  estimate.refresh_map_scale();
}

}  // namespace limber
