// SPDX-License-Identifier: MIT
#include "check_inputs.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_set>

#include "limber/core/time.hpp"

namespace limber::detail {
namespace {

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
  require(o.constant_velocity_noise.acceleration_density, true,
          "constant_velocity_noise.acceleration_density");
  require(o.constant_velocity_noise.angular_acceleration_density, true,
          "constant_velocity_noise.angular_acceleration_density");
  require(o.theta_sigma, true, "theta_sigma");
  if (o.theta_walk) {
    require(*o.theta_walk, true, "theta_walk");
  }
  if (!(o.gate_probability > 0.0 && o.gate_probability < 1.0)) {
    throw std::invalid_argument("navigator: gate_probability must lie between 0 and 1");
  }
}

void check_initial(const InitialState& initial) {
  const NavigationState& nav = initial.nav;
  if (!nav.T_world_body.p.allFinite() || !nav.T_world_body.R.allFinite() || !nav.v_world_body.allFinite() ||
      !nav.omega_body.allFinite() || !nav.bias_gyro.allFinite() || !nav.bias_accel.allFinite() ||
      !initial.body_covariance.allFinite()) {
    throw std::invalid_argument("navigator: the initial state is not finite");
  }
  require(initial.body_covariance.diagonal(), true, "a variance of the initial state");
}

void check_frame(const StereoFrame& frame, std::int64_t state_ns, std::int64_t previous_ns) {
  const auto fail = [&](const std::string& what) {
    throw std::invalid_argument("frame at " + std::to_string(frame.t_ns) + " ns " + what);
  };
  if (frame.t_ns < state_ns) {
    fail("is older than the state, " + std::to_string(state_ns) + " ns");
  }
  if (frame.t_ns <= previous_ns) {
    fail("is not later than the frame before it");
  }
  if (seconds_between(state_ns, frame.t_ns) > kLongestJump) {
    fail("is " + std::to_string(seconds_between(state_ns, frame.t_ns)) + " s ahead of the state, " +
         std::to_string(state_ns) + " ns: is that another clock?");
  }
  std::unordered_set<std::int64_t> seen;
  for (const StereoObservation& o : frame.observations) {
    if ((o.in_cam0 && !o.uv_cam0.allFinite()) || (o.in_cam1 && !o.uv_cam1.allFinite())) {
      fail("has a pixel that is not finite, track " + std::to_string(o.track_id));
    }
    if (!seen.insert(o.track_id).second) {
      fail("holds track " + std::to_string(o.track_id) + " twice");
    }
  }
}

}  // namespace limber::detail
