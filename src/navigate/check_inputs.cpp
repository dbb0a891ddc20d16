// SPDX-License-Identifier: MIT
#include "check_inputs.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_set>

#include "limber/core/so3.hpp"
#include "limber/core/time.hpp"
#include "limber/sensors/parameters.hpp"

namespace limber::detail {
namespace {

constexpr double kRounding = 1e-6;  // of a correlation

template <typename Derived>
void require(const Eigen::DenseBase<Derived>& values, bool zero_allowed, const std::string& name) {
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    const double value = values.derived().coeff(k);
    if (!std::isfinite(value) || value < 0.0 || (value == 0.0 && !zero_allowed)) {
      throw std::invalid_argument("navigator: " + name + " is " + std::to_string(value) + ", expected a " +
                                  (zero_allowed ? "number that is not negative" : "positive number"));
    }
  }
}

void require(double value, bool zero_allowed, const std::string& name) {
  require(Eigen::Matrix<double, 1, 1>(value), zero_allowed, name);
}

void require_finite(const Eigen::MatrixXd& values, const std::string& name) {
  if (!values.allFinite()) {
    throw std::invalid_argument("navigator: " + name + " of the initial state is not finite");
  }
}

/// In correlations, which have no unit. What no covariance of the state's size is, Estimate says.
void check_covariance(const Eigen::MatrixXd& P) {
  require_finite(P, "the covariance");
  require(P.diagonal(), true, "a variance of the initial state");
  if (P.size() == 0 || P.rows() != P.cols()) {
    return;
  }
  const Eigen::VectorXd scale =
      (P.diagonal().array() > 0.0).select(P.diagonal().cwiseSqrt().cwiseInverse(), 1.0);
  const Eigen::MatrixXd C = scale.asDiagonal() * P * scale.asDiagonal();
  const double asymmetry = (C - C.transpose()).cwiseAbs().maxCoeff();
  if (!(asymmetry <= kRounding)) {
    throw std::invalid_argument(
        "navigator: the covariance of the initial state is not symmetric: two of its correlations differ "
        "by " +
        std::to_string(asymmetry));
  }
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(C, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
  if (!(least >= -kRounding)) {
    throw std::invalid_argument(
        "navigator: the covariance of the initial state is not positive semidefinite: least eigenvalue of "
        "its correlations is " +
        std::to_string(least));
  }
}

[[noreturn]] void refuse(const StereoFrame& frame, const std::string& what) {
  throw std::invalid_argument("frame at " + std::to_string(frame.t_ns) + " ns " + what);
}

}  // namespace

void check_options(const NavigatorOptions& o) {
  require(o.sigma_px, false, "sigma_px");
  require(o.gravity, true, "gravity");
  require(o.imu_noise.gyro_density, true, "imu_noise.gyro_density");
  require(o.imu_noise.gyro_walk, true, "imu_noise.gyro_walk");
  require(o.imu_noise.accel_density, true, "imu_noise.accel_density");
  require(o.imu_noise.accel_walk, true, "imu_noise.accel_walk");
  require(o.odometry_noise.sigma_v, true, "odometry_noise.sigma_v");
  require(o.odometry_noise.sigma_omega, true, "odometry_noise.sigma_omega");
  require(o.odometry_scale, true, "odometry_scale");
  require(o.constant_velocity_noise.acceleration_density, true,
          "constant_velocity_noise.acceleration_density");
  require(o.constant_velocity_noise.angular_acceleration_density, true,
          "constant_velocity_noise.angular_acceleration_density");
  require(o.theta_sigma, true, "theta_sigma");
  if (o.theta_walk) {
    require(*o.theta_walk, true, "theta_walk");
  }
  if (o.map.points_per_update == 0) {
    throw std::invalid_argument("navigator: expected at least one point per update");
  }
  if (!(o.gate_probability > 0.0 && o.gate_probability < 1.0)) {
    throw std::invalid_argument("navigator: gate_probability must lie between 0 and 1");
  }
}

void check_initial(const InitialState& initial) {
  const NavigationState& nav = initial.nav;
  require_finite(nav.T_world_body.p, "the position");
  require_finite(nav.v_world_body, "the velocity");
  require_finite(nav.omega_body, "the rate");
  require_finite(nav.bias_gyro, "the gyro bias");
  require_finite(nav.bias_accel, "the accelerometer bias");
  require_rotation(nav.T_world_body.R, "navigator: the attitude of the initial state");
  check_covariance(initial.body_covariance);
  for (const Landmark& landmark : initial.landmarks) {
    require_finite(landmark.value, "landmark " + std::to_string(landmark.track_id));
  }
  require_finite(initial.landmarks_covariance, "the covariance of landmarks");
  require_finite(initial.landmarks_body, "the covariance of landmarks and body");
  require_finite(initial.by_parameters, "what body and landmarks owe to parameters");
  const auto errors =
      initial.body_covariance.rows() + kTriplet * static_cast<Eigen::Index>(initial.landmarks.size());
  if (initial.by_parameters.size() > 0 &&
      (initial.by_parameters.rows() != errors || initial.by_parameters.cols() != kMoreParameters)) {
    throw std::invalid_argument("navigator: expected by_parameters of " + std::to_string(errors) + " x " +
                                std::to_string(kMoreParameters) + " in the initial state");
  }
  require_finite(initial.by_clock, "what body and landmarks owe to the clock");
  if (!(initial.clock_sigma >= 0.0) || !std::isfinite(initial.clock_sigma)) {
    throw std::invalid_argument(
        "navigator: clock_sigma of the initial state must be finite and not negative");
  }
  if (initial.clock_sigma > 0.0 && initial.by_clock.size() != errors) {
    throw std::invalid_argument("navigator: expected by_clock of " + std::to_string(errors) +
                                " in the initial state");
  }
}

void check_frame(const StereoFrame& frame, std::int64_t state_ns, std::int64_t previous_ns) {
  if (frame.t_ns < state_ns) {
    refuse(frame, "is older than the state, " + std::to_string(state_ns) + " ns");
  }
  if (frame.t_ns <= previous_ns) {
    refuse(frame, "is not later than the frame before it");
  }
  if (seconds_between(state_ns, frame.t_ns) > kLongestJump) {
    refuse(frame, "is " + std::to_string(seconds_between(state_ns, frame.t_ns)) + " s ahead of the state, " +
                      std::to_string(state_ns) + " ns: is that another clock?");
  }
  check_points(frame);
  std::unordered_set<std::int64_t> seen;
  for (const StereoObservation& o : frame.observations) {
    if (!seen.insert(o.track_id).second) {
      refuse(frame, "holds track " + std::to_string(o.track_id) + " twice");
    }
  }
}

}  // namespace limber::detail
