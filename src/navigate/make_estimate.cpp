// SPDX-License-Identifier: MIT
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "check_inputs.hpp"
#include "parameter_roles.hpp"

namespace limber::detail {

using Eigen::MatrixXd;

namespace {

/// Whether what the gain is blind to, or the lack of a right camera, hides a common factor of all lengths.
bool leaves_scale_unseen(const NavigatorOptions& options, const StereoCalibration& calibration) {
  if (options.method == Method::kMonoLeft) {
    return true;
  }
  if (options.method != Method::kLcekf) {
    return false;
  }
  const MatrixXd C = constraint_directions(options.constraints, calibration.theta);
  Eigen::Matrix<double, 6, 1> longer = calibration.theta;
  longer.head<3>().setZero();
  return C.cols() > 0 &&
         (longer - C * C.completeOrthogonalDecomposition().solve(longer)).norm() < 1e-9 * longer.norm();
}

/// A start that knows its scale this well [-] is followed as it always was: what is learned by chance is less
/// than what accelerations tell.
constexpr double kVagueScale = 0.03;

/// How well a start's map knows how long a metre is [-]: its best depth. Without a map, none is claimed.
double scale_sigma(const InitialState& initial) {
  double best = initial.landmarks.empty() ? 0.0 : std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < initial.landmarks.size(); ++k) {
    const Eigen::Index at = kTriplet * static_cast<Eigen::Index>(k) + 2;
    const double rho = initial.landmarks[k].value.z();
    if (rho > 0.0) {  // others know nothing of a depth
      best = std::min(best, std::sqrt(initial.landmarks_covariance(at, at)) / rho);
    }
  }
  return best;
}

}  // namespace

Estimate make_estimate(const NavigatorOptions& options, const StereoCalibration& calibration,
                       const InitialState& initial) {
  if (!(calibration.baseline() > 0.0)) {
    throw std::invalid_argument("navigator: the baseline is " + std::to_string(calibration.baseline()) +
                                " m, expected a positive one");
  }
  check_initial(initial);
  StateLayout layout{options.motion, has_theta(options), has_witness(options)};
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    layout.has_more[k] = (estimated(options) & parameters_of(kMoreBlocks[k])).any();
  }
  layout.has_map_scale = options.motion != MotionModel::kOdometry &&
                         leaves_scale_unseen(options, calibration) && scale_sigma(initial) > kVagueScale;
  Estimate out(layout, initial.nav, initial.body_covariance, calibration.theta,
               theta_prior(options, calibration).cwiseAbs2().asDiagonal());
  const ParameterVector prior =
      options.estimated.cwiseMax(kNotEstimated * plausible_errors(calibration)).cwiseAbs2();
  for (std::size_t k = 0; k < kMoreBlocks.size(); ++k) {
    if (layout.has_more[k]) {
      out.P.set_diagonal_block(layout.more(k),
                               MatrixXd(prior.segment<6>(first_of(kMoreBlocks[k])).asDiagonal()));
    }
  }
  if (has_witness(options)) {
    out.restart_witness(kWidestErrors);
  }
  return out;
}

}  // namespace limber::detail
