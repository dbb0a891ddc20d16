// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "limber/health/health_monitor.hpp"
#include "limber/health/white_size.hpp"
#include "limber/map/birth.hpp"
#include "limber/map/estimate.hpp"
#include "limber/map/stack_frame.hpp"
#include "limber/map/upkeep.hpp"
#include "limber/method.hpp"
#include "limber/predict/input_buffer.hpp"
#include "limber/predict/motion.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/update/update.hpp"

namespace limber {

/// Everything a navigator is told before it starts. Defaults are those of a small visual-inertial rig.
struct NavigatorOptions {
  Method method = Method::kLcekf;
  ConstraintSet constraints;  ///< lcekf only
  /// Standard deviations of parameters that are estimated beside what the method does with theta; zero: not.
  /// Each walks by 1 % of it per sqrt(s). Not with theta for ekf-full, consider and adaptive: those have it.
  ParameterVector estimated = ParameterVector::Zero();
  /// Standard deviations of errors that are fresh in every frame (time-white), beside theta of soft; zero:
  /// none.
  ParameterVector softened = ParameterVector::Zero();
  MotionModel motion = MotionModel::kImu;

  ImuNoise imu_noise;
  OdometryNoise odometry_noise;  ///< per sample
  ConstantVelocityNoise constant_velocity_noise;
  PixelNoise sigma_px = PixelNoise::Constant(0.5);
  double gravity = 9.81;  ///< [m/s^2]

  /// ekf-full, consider, soft: standard deviation of theta [rad, m]. Zero: one plausible error (0.1 deg, 5
  /// %).
  RigParameters theta_sigma = RigParameters::Zero();
  /// ekf-full: random walk of theta, variance per second [rad^2/s, m^2/s]; Table 1, 'well estimated', at 100
  /// Hz.
  RigParameters theta_walk = (RigParameters() << 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4).finished();

  LandmarkKind landmarks = LandmarkKind::kInverseDepth;
  BirthOptions birth;  ///< mode and kind are set from method and landmarks
  UpkeepOptions upkeep;
  bool gate = true;
  double gate_probability = 0.999;  ///< chance that a good point passes
  /// Watches the calibration; nothing: off. mono-left has nothing to watch.
  std::optional<HealthOptions> health = HealthOptions{};
};

/// Where to start.
struct InitialState {
  NavigationState nav;
  Eigen::MatrixXd body_covariance;  ///< StateLayout::body_size() wide
};

/// How wrong the rig that `adaptive` takes for true may be from now on; both are learned from there.
struct Doubt {
  Eigen::Matrix<double, 6, 6> jump;  ///< covariance of what has changed and stays [plausible errors squared]
  WhiteSize::Vector6 fresh;  ///< at least that large is what changes in every frame [plausible errors]
};

/// What a filter has learned of the calibration that it was given.
struct CalibrationEstimate {
  ParameterSet parameters;                          ///< those it estimates; the others are zero below
  ParameterVector error = ParameterVector::Zero();  ///< true minus given
  ParameterVector sigma = ParameterVector::Zero();  ///< standard deviation of that
};

/// What became of one frame.
struct FrameReport {
  std::int64_t t_ns = 0;
  UpdateStatus status = UpdateStatus::kEmpty;
  double nis = 0.0;       ///< of the projected rows [-]
  Eigen::Index dof = 0;   ///< of nis
  Eigen::Index rank = 0;  ///< constrained directions that this frame's geometry can see
  std::size_t observed = 0;
  std::size_t used = 0;
  std::size_t born = 0;
  std::size_t removed = 0;
  bool gate_overruled = false;  ///< the gate would have refused most points, so it refused none
  std::vector<Refusal> refused;
  std::optional<HealthReport> health;  ///< if watched
  /// What the frame says against the rig that the filter takes for true (ekf-full, adaptive: its estimate).
  std::optional<HealthInput> evidence;
};

/// @brief Stereo navigation for a rig that bends: inputs in, frames in, state out.
///
/// Feed inputs up to (or beyond) a frame's time, then the frame. One navigator, one thread.
class Navigator {
 public:
  /// @param calibration  what the filter assumes; never the truth (but see oracle)
  /// @throws std::invalid_argument if options contradict each other or shapes disagree
  Navigator(const NavigatorOptions& options, const StereoCalibration& calibration,
            const InitialState& initial);

  /// @throws std::invalid_argument if time does not increase or a value is not finite
  void add_imu(const ImuSample& sample);
  void add_odometry(const OdometrySample& sample);

  /// Advances the state to t_ns with the inputs so far; nothing happens if t_ns is not later.
  void predict_to(std::int64_t t_ns);

  /// @brief Predict, bear, update, keep up: one stereo frame.
  /// @throws std::invalid_argument if the frame is older than the state, a pixel is not finite or an id comes
  /// twice
  FrameReport process(const StereoFrame& frame);

  /// adaptive: begins to estimate theta, as a constant that walks and a part that is fresh in every frame,
  /// instead of trusting it. Told by whoever found out (SupervisedNavigator).
  void distrust(const Doubt& doubt);

  /// adaptive: takes over the state of a constrained filter (lcekf with a witness, all six directions or
  /// fewer), which was led astray by nothing; what its witness has learned becomes theta.
  void take_over(const Navigator& constrained, const Doubt& doubt);

  /// What the filter assumes from now on. For `oracle`, which the application feeds with the truth.
  void assume_theta(const RigParameters& theta);

  /// The calibration that the filter takes for true: what was given, with what has been estimated.
  [[nodiscard]] const StereoCalibration& calibration() const { return calibration_; }
  [[nodiscard]] CalibrationEstimate calibration_estimate() const;

  [[nodiscard]] const Estimate& estimate() const { return estimate_; }
  [[nodiscard]] const NavigatorOptions& options() const { return options_; }

 private:
  using Newborn = std::unordered_map<std::int64_t, UnspentRows>;

  [[nodiscard]] Transition predict_step(const InputStep& step);
  [[nodiscard]] std::vector<InputStep> steps_to(std::int64_t t_ns);
  [[nodiscard]] Newborn bear(const StereoFrame& frame);
  /// @param shift  from the assumed calibration to the one at which this frame is linearised
  void update_with(const StereoFrame& frame, const Newborn& newborn, const ParameterVector& shift, double dt,
                   FrameReport& report);
  void book(const StackedFrame& stacked, const std::vector<bool>& accepted, const Newborn& newborn,
            FrameReport& report);
  [[nodiscard]] Eigen::MatrixXd doubted() const;
  [[nodiscard]] MountedRig mounted(const StereoCalibration& calibration) const;
  void use_estimated_calibration();
  [[nodiscard]] ParameterTreatment treatment() const;
  [[nodiscard]] BirthMode birth_mode() const;
  void walk_parameters(double dt);
  void learn_from(const ParameterTreatment& how, const UpdateReport& update, double dt, FrameReport& report);
  [[nodiscard]] std::optional<ParameterEvidence> gathered(const ParameterTreatment& how) const;

  NavigatorOptions options_;
  StereoCalibration given_;        // as assumed at the start
  StereoCalibration calibration_;  // the one in use
  RigParameters scale_;            // one plausible error of theta of the calibration that was given
  MountedRig rig_;
  Estimate estimate_;
  InputBuffer inputs_;
  Eigen::Vector3d omega_input_ = Eigen::Vector3d::Zero();  // [rad/s], of the last step: gyro or odometry
  std::optional<HealthMonitor> monitor_;
  WhiteSize fresh_;  // adaptive: zero as long as theta is trusted
  std::int64_t last_frame_ns_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace limber
