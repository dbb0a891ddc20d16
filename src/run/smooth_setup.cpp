// SPDX-License-Identifier: MIT
#include "run/smooth_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "limber/predict/learned_odometry_noise.hpp"
#include "run/samples_as_taken.hpp"

namespace limber::detail {
namespace {

using L = StateLayout;

constexpr double kWorthANote = 1.2;  // times the stated noise
constexpr int kMaxIterations = 100;
// What is known of an automatic start beforehand: where the world's origin and axes are, and plausible
// biases.
constexpr double kPriorTilt = 0.5;       // [rad]
constexpr double kPriorVelocity = 30.0;  // [m/s]
constexpr double kPriorRate = 10.0;      // [rad/s]
constexpr double kPriorBiasGyro = 0.1;   // [rad/s]
constexpr double kPriorBiasAccel = 0.1;  // [m/s^2]
constexpr double kYaw = 1e-4;            // [rad], by convention zero

/// The states of the moments from which a start was made, which no filter went through.
std::vector<NavigationState> states_before(const std::vector<TrajectoryRow>& rows, std::size_t count) {
  std::vector<NavigationState> out;
  for (std::size_t k = 0; k < count; ++k) {
    NavigationState state;
    state.t_ns = rows[k].t_ns;
    state.T_world_body = rows[k].T_world_body;
    state.v_world_body = rows[k].v_world_body.value_or(Eigen::Vector3d::Zero());
    state.bias_gyro = rows[k].bias_gyro.value_or(Eigen::Vector3d::Zero());
    state.bias_accel = rows[k].bias_accel.value_or(Eigen::Vector3d::Zero());
    out.push_back(state);
  }
  return out;
}

/// Learned from all samples, where nobody stated it; at the speed that the body has on average.
OdometryNoise odometry_noise(const NavigatorOptions& navigator, const SensorData& sensors) {
  if (!navigator.learn_odometry_noise || sensors.odometry.empty()) {
    return navigator.odometry_noise;
  }
  LearnedOdometryNoise learned(navigator.odometry_noise);
  double speeds = 0.0;
  for (const OdometrySample& sample : sensors.odometry) {
    learned.add(sample);
    speeds += sample.v_body.norm();
  }
  return learned.assumed(speeds / static_cast<double>(sensors.odometry.size()));
}

}  // namespace

StereoFrame KeptFrames::operator()(std::size_t n) {
  while (frames_.size() <= n) {
    StereoFrame next = source_(frames_.size());
    withdraw_from(frames_, next);
    frames_.push_back(std::move(next));
  }
  return frames_[n];
}

std::vector<StereoFrame> KeptFrames::from(std::int64_t first_ns) const {
  std::vector<StereoFrame> out;
  std::copy_if(frames_.begin(), frames_.end(), std::back_inserter(out),
               [&](const StereoFrame& frame) { return frame.t_ns >= first_ns; });
  return out;
}

Guess guess_by(Method method, const Recording& recording, RunOptions options, KeptFrames& frames,
               const std::function<void(std::size_t)>& progress) {
  options.method = method;
  options.constraints.reset();
  options.estimated.setZero();
  options.softened.setZero();
  options.watch = false;
  options.cleaning.clean = options.cleaning.still_points = false;  // its frames are clean already,
  options.cleaning.refer_to_stamp = false;                         // and where they were at their stamps
  Guess out;
  out.record = run_recording(recording, options, [&frames](std::size_t n) { return frames(n); },
                             {.progress = progress, .observe = [&out](const ObservedFrame& frame) {
                                if (frame.navigator != nullptr) {
                                  out.states.push_back(frame.navigator->estimate().nav());
                                }
                              }});
  const std::vector<NavigationState> before =
      states_before(out.record.trajectory, out.record.trajectory.size() - out.states.size());
  out.states.insert(out.states.begin(), before.begin(), before.end());
  out.imu = samples_as_taken(recording, out.record, out.states.front().t_ns);
  return out;
}

InitialState without_data(const NavigationState& first, MotionModel motion) {
  InitialSigma sigma;
  sigma.attitude = kYaw;
  sigma.velocity = kPriorVelocity;
  sigma.bias_gyro = kPriorBiasGyro;
  sigma.bias_accel = kPriorBiasAccel;
  sigma.rate = kPriorRate;
  InitialState start = make_initial_state(first, motion, sigma);
  if (motion == MotionModel::kImu) {
    const Eigen::Matrix3d& R = first.T_world_body.R;
    const Eigen::Vector3d world(kPriorTilt, kPriorTilt, kYaw);
    start.body_covariance.block<3, 3>(L::kAttitude, L::kAttitude) =
        R.transpose() * world.cwiseAbs2().asDiagonal() * R;
  }
  return start;
}

SmootherOptions smoother_options(const SensorData& sensors, const SmoothOptions& options,
                                 const RunSetup& setup, std::vector<std::string>& notes) {
  const NavigatorOptions& navigator = setup.navigator;
  SmootherOptions out;
  out.motion = navigator.motion;
  out.noise = {navigator.imu_noise, odometry_noise(navigator, sensors), navigator.constant_velocity_noise};
  out.sigma_px = navigator.sigma_px;
  out.gravity = navigator.gravity;
  out.rig = options.rig;
  out.piece_s = options.piece_s;
  out.trust_length = options.rig != RigModel::kTrusted && !has_scale(navigator.motion);
  if (out.trust_length) {
    notes.emplace_back("theta: nothing but the baseline's length fixes the scale, so it is trusted");
  }
  out.rig_sigma = options.run.theta_sigma.value_or(RigParameters::Zero());
  out.rig_walk = navigator.theta_walk.value_or(default_theta_walk(setup.calibration.baseline()));
  out.estimated = options.run.estimated;
  out.loss = options.loss;
  out.forget_after_s = navigator.map.forget_after_s;
  out.max_iterations = kMaxIterations;
  out.threads = options.threads;
  return out;
}

void take_imu_noise(const std::optional<ImuNoiseFactors>& learned, SmootherOptions& how,
                    std::vector<std::string>& notes) {
  if (!learned || std::max(learned->gyro, learned->accel) < kWorthANote) {
    return;
  }
  how.noise.imu.gyro_density *= learned->gyro;
  how.noise.imu.accel_density *= learned->accel;
  notes.push_back(
      fmt::format("the IMU errs more than its stated noise: {:.2g} times that of the gyroscope and {:.2g} "
                  "times that of the "
                  "accelerometer are assumed, as the filter of the first guess learned",
                  learned->gyro, learned->accel));
}

}  // namespace limber::detail
