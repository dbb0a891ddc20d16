// SPDX-License-Identifier: MIT
#include "limber/state/initial_state.hpp"

#include "limber/sensors/parameters.hpp"

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

namespace {

/// What is said of body and points (if they were placed), where they stand in the state.
Eigen::MatrixXd in_state(const Estimate& estimate, const Eigen::MatrixXd& of_body_and_points) {
  using Eigen::Index;
  const Index body = estimate.layout().body_size(), points = of_body_and_points.rows() - body;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(estimate.size(), of_body_and_points.cols());
  out.topRows(body) = of_body_and_points.topRows(body);
  if (points > 0 && !estimate.landmarks().empty()) {
    out.middleRows<L::kPoseSize>(estimate.size() - points - L::kPoseSize) = out.topRows<L::kPoseSize>();
    out.bottomRows(points) = of_body_and_points.bottomRows(points);
  }
  return out;
}

}  // namespace

/// [s; 1] times the parameter's error, added to what is known without it, is the joint covariance but for the
/// parameter's own, which is there already.
void correlate_with_parameters(Estimate& estimate, const InitialState& initial) {
  using Eigen::Index;
  using Eigen::MatrixXd;
  if (initial.by_parameters.size() == 0) {
    return;
  }
  const StateLayout& layout = estimate.layout();
  for (std::size_t block = 0; block < layout.has_more.size(); ++block) {
    if (!layout.has_more[block]) {
      continue;
    }
    const Index at = layout.more(block);
    const MatrixXd prior = estimate.P().diagonal_block<kBlockSize>(at);
    MatrixXd W = in_state(
        estimate, initial.by_parameters.middleCols(static_cast<Index>(block) * kBlockSize, kBlockSize));
    W.middleRows(at, kBlockSize).setIdentity();
    estimate.mutable_P().add_outer(W * prior.diagonal().cwiseSqrt().asDiagonal());
    estimate.mutable_P().set_diagonal_block(at, prior);
  }
  estimate.refresh_map_scale();
}

void correlate_with_clock(Estimate& estimate, const InitialState& initial) {
  if (initial.clock_sigma == 0.0) {
    return;
  }
  Eigen::MatrixXd W = initial.clock_sigma * in_state(estimate, initial.by_clock);
  W(estimate.layout().clock_step(), 0) = initial.clock_sigma;
  estimate.mutable_P().add_outer(W);
  estimate.refresh_map_scale();
}

}  // namespace limber
