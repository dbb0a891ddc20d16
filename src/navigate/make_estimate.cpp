// SPDX-License-Identifier: MIT
#include <Eigen/QR>
#include <algorithm>

#include "check_inputs.hpp"
#include "parameter_roles.hpp"

namespace limber::detail {

using Eigen::MatrixXd;

namespace {

/// Whether what the gain is blind to, or the lack of a right camera, hides a common factor of all lengths;
/// or leaves it open, where the baseline is estimated or doubted.
bool leaves_scale_unseen(const NavigatorOptions& options, const StereoCalibration& calibration) {
  if (options.method == Method::kEkf || options.method == Method::kOracle) {
    return false;
  }
  if (options.method != Method::kLcekf) {
    return true;
  }
  const MatrixXd C = constraint_directions(options.constraints, calibration.theta);
  Eigen::Matrix<double, 6, 1> longer = calibration.theta;
  longer.head<3>().setZero();
  return C.cols() > 0 &&
         (longer - C * C.completeOrthogonalDecomposition().solve(longer)).norm() < 1e-9 * longer.norm();
}

}  // namespace

Estimate make_estimate(const NavigatorOptions& options, const StereoCalibration& calibration,
                       const InitialState& initial) {
  check_calibration(calibration);
  check_initial(initial);
  StateLayout layout{options.motion, has_theta(options), has_witness(options)};
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    layout.has_more[k] = (estimated(options) & parameters_of(kMoreBlocks[k])).any();
  }
  layout.has_more.back() = layout.has_more.back() || options.doubt_odometry_mount;
  layout.has_map_scale =
      leaves_scale_unseen(options, calibration) &&
      (options.carries_scale || options.motion == MotionModel::kOdometry || !initial.landmarks.empty());
  layout.has_odometry_scale = options.motion == MotionModel::kOdometry && options.odometry_scale > 0.0;
  layout.has_supposed_steps = options.motion == MotionModel::kImu;
  Estimate out(layout, initial.nav, initial.body_covariance, calibration.theta,
               theta_prior(options, calibration).cwiseAbs2().asDiagonal());
  if (initial.landmarks.empty()) {  // a start from the sensors has the world's origin at its own begin
    out.set_centre_of_growth(initial.nav.T_world_body.p);
  }
  ParameterVector prior =
      options.estimated.cwiseMax(kNotEstimated * plausible_errors(calibration)).cwiseAbs2();
  if (options.doubt_odometry_mount) {
    prior.segment<3>(first_of(ParameterBlock::kMount)) = mount_sigma(calibration).cwiseAbs2();
  }
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    if (layout.has_more[k]) {
      out.mutable_P().set_diagonal_block(layout.more(k),
                                         MatrixXd(prior.segment<6>(first_of(kMoreBlocks[k])).asDiagonal()));
    }
  }
  if (has_witness(options)) {
    out.restart_witness(kWidestErrors);
  }
  if (layout.has_odometry_scale) {
    out.set_odometry_scale_sigma(options.odometry_scale);
  }
  return out;
}

}  // namespace limber::detail
