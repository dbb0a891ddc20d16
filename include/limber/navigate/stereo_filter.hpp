// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <unordered_map>
#include <vector>

#include "limber/health/health_monitor.hpp"
#include "limber/health/input_alarm.hpp"
#include "limber/health/learned_imu_noise.hpp"
#include "limber/health/learned_pixel_noise.hpp"
#include "limber/health/white_size.hpp"
#include "limber/landmarks/bearing_walk.hpp"
#include "limber/landmarks/landmark_budget.hpp"
#include "limber/navigate/frame_report.hpp"
#include "limber/navigate/moving_tracks.hpp"
#include "limber/navigate/navigator_options.hpp"
#include "limber/navigate/usual_scatter.hpp"
#include "limber/predict/input_buffer.hpp"
#include "limber/predict/input_checks.hpp"
#include "limber/predict/input_noise.hpp"
#include "limber/predict/learned_odometry_noise.hpp"
#include "limber/predict/scale_excitation.hpp"
#include "limber/stack/stack_frame.hpp"
#include "limber/state/estimate.hpp"
#include "limber/state/initial_state.hpp"
#include "limber/update/frame_innovation.hpp"
#include "limber/update/gate.hpp"
#include "limber/update/update.hpp"

namespace limber {

namespace detail {
struct Propagation;
}
namespace testing {
struct StereoFilterDoubt;
}

/// How wrong the rig that `adaptive` takes for true may be from now on; both are learned from there.
struct CalibrationPrior {
  Eigen::Matrix<double, 6, 6> jump;  ///< covariance of what has changed and stays [plausible errors squared]
  WhiteSize::Vector6 fresh;  ///< at least that large is what changes in every frame [plausible errors]
};

/// The body at a time that no frame has: mean, and covariance of its error state.
struct PredictedState {
  /// mean at the time asked for
  NavigationState nav;
  Eigen::MatrixXd body_covariance;  ///< StateLayout::body_size() wide
};

/// @brief One filter of any method, without what `adaptive` needs beside it: Navigator is what users want.
///
/// Feed inputs up to (or beyond) a frame's time, then the frame. One filter, one thread.
class StereoFilter {
 public:
  /// @param calibration  what the filter assumes; never the truth (but see oracle)
  /// @throws std::invalid_argument if options contradict each other, shapes disagree, the calibration is one
  /// that no rig has (check_calibration), or the initial state is none: not finite, an attitude that is no
  /// rotation matrix, a covariance that is not symmetric and positive semidefinite
  StereoFilter(const NavigatorOptions& options, const StereoCalibration& calibration,
               const InitialState& initial);

  /// @brief One sample; samples that cannot be right are left out or doubted (InputChecks), those older than
  /// the state are of no more use than to say what was measured last: both are counted in the next frame's
  /// report.
  /// @throws std::invalid_argument if time does not increase, lies hours ahead, or a value is not finite
  void add_imu(const ImuSample& sample);
  /// As add_imu, in the place of an IMU.
  void add_odometry(const OdometrySample& sample);

  /// How much later than taken an IMU's samples are stamped by now, as far as the images showed it [ns]: they
  /// are used so. Where it is positive, feed them up to a frame's time and as much more.
  [[nodiscard]] std::int64_t clock_offset_ns() const { return clock_offset_ns_; }

  /// Advances the state to t_ns with the inputs so far; nothing happens if t_ns is not later.
  void predict_to(std::int64_t t_ns);

  /// The body at t_ns with the inputs so far; changes nothing. The state itself if t_ns is not later. Where
  /// nothing but the baseline tells lengths and the noise of the pixels is learned, its covariance is that of
  /// estimate() and what lenses may do to all lengths: PixelNoiseReport::length_sigma.
  [[nodiscard]] PredictedState predict(std::int64_t t_ns) const;

  /// @brief One stereo frame.
  ///
  /// A state that was never given a time (0) takes that of the first sample or frame, if that is more than a
  /// minute ahead. If the covariance turns out to be broken or the state is not finite, the filter begins
  /// anew: it keeps time, pose, velocity and biases of the last sound frame, forgets the map, and is as
  /// unsure of the rest as of any start (docs/faults.md).
  /// @throws std::invalid_argument if the frame is older than the state, not later than the frame before, or
  /// hours ahead, a pixel is not finite or a million pixels away, or an id comes twice; nothing has changed
  FrameReport process(const StereoFrame& frame);

  /// The door of `oracle`, and of nobody else: the rig as it is from now on, which the filter takes for true.
  /// @throws std::logic_error for any other method
  /// @throws std::invalid_argument if theta is not finite or has no baseline
  void show_true_rig(const TrueRig& truth);

  /// The calibration that the filter takes for true: what was given, with what has been estimated.
  [[nodiscard]] const StereoCalibration& calibration() const { return calibration_; }
  /// What has been learned of the calibration; zero where nothing is estimated.
  [[nodiscard]] CalibrationEstimate calibration_estimate() const;
  /// What was given, whatever has been estimated or assumed since.
  [[nodiscard]] const StereoCalibration& given_calibration() const { return given_; }

  /// Mean and covariance. Invalidated by the next call that is not const.
  [[nodiscard]] const Estimate& estimate() const { return estimate_; }
  /// As they were given at the construction.
  [[nodiscard]] const NavigatorOptions& options() const { return options_; }
  /// What is learned of the pixels; null unless it is asked for.
  [[nodiscard]] const LearnedPixelNoise* pixel_noise() const {
    return pixel_noise_ ? &*pixel_noise_ : nullptr;
  }
  /// What is learned of an IMU; null unless it is asked for.
  [[nodiscard]] const LearnedImuNoise* imu_noise() const { return imu_noise_ ? &*imu_noise_ : nullptr; }
  /// The same of a motion that nothing measures.
  [[nodiscard]] const LearnedImuNoise* learned_motion_noise() const {
    return motion_noise_ ? &*motion_noise_ : nullptr;
  }
  /// What is learned of odometry; null unless it is asked for.
  [[nodiscard]] const LearnedOdometryNoise* odometry_noise() const {
    return odometry_noise_ ? &*odometry_noise_ : nullptr;
  }

 private:
  friend class Navigator;  // which has several of them and tells one what another has seen
  friend struct testing::StereoFilterDoubt;

  /// Opens the state for what the images of a filter beside this one said against the inputs: velocity and
  /// biases may be off by as much, and for some time the inputs are noisier by as much. Or a step that they
  /// found: of the biases, or of the clock, whose offset is taken for true.
  void distrust_inputs(const InputContradiction& found);

  /// adaptive: begins to estimate theta, as a constant that walks and a part that is fresh in every frame,
  /// instead of trusting it. Told by whoever found out (Navigator).
  void distrust(const CalibrationPrior& prior);

  /// adaptive: takes over the state of a constrained filter (lcekf with a witness, all six directions or
  /// fewer), which was led astray by nothing; what its witness has learned becomes theta.
  void take_over(const StereoFilter& constrained, const CalibrationPrior& prior);

  /// adaptive, as long as it trusts: takes over the state of such a filter where an input that fails has led
  /// it astray. Theta stays what it was.
  void follow(const StereoFilter& constrained);

  /// adaptive: the IMU is as noisy as such a filter has learned, which no rig can lead astray.
  void share_imu_noise(const StereoFilter& constrained) { imu_noise_ = constrained.imu_noise_; }

  /// adaptive: an epoch of the map does not end in the next frame, because that of the filter beside ends
  /// then.
  void postpone_epoch() { postpones_epoch_ = true; }

  /// Landmarks that are new in this frame, with those of its rows that the update may still use.
  using NewLandmarks = std::unordered_map<std::int64_t, RemainingRows>;
  /// The rig at which a frame is linearised, and how far that is from the assumed one.
  struct LinearizationPoint {
    MountedRig rig;
    ParameterVector shift = ParameterVector::Zero();
  };

  /// A correction that was worked out before it was made.
  struct Correction {
    Covariance P;  ///< after it
    UpdateReport report;
  };

  /// A frame's rows, and which of its points are taken.
  struct Attempt {
    LinearizationPoint at;
    NewLandmarks new_landmarks;
    StackedFrame stacked;
    FrameInnovation seen;
    std::vector<bool> accepted;
    bool lost = false;                       ///< iterated, and the images do not say where the body is
    std::optional<Correction> correction{};  ///< where it had to be known
  };

  void add(InputSample sample);
  void take_in(const StereoFrame& frame, FrameReport& report);
  /// The time of the state once something of t_ns has come.
  [[nodiscard]] std::int64_t started_at(std::int64_t t_ns) const;
  [[nodiscard]] std::vector<InputStep> steps_to(std::int64_t t_ns) const;
  [[nodiscard]] detail::Propagation propagated(std::int64_t t_ns) const;
  [[nodiscard]] ConstantVelocityNoise motion_noise() const;
  [[nodiscard]] MoreNoise more_noise() const;
  [[nodiscard]] InputReport report_inputs(std::int64_t t_ns);
  [[nodiscard]] bool is_blind_to_rig() const;
  void judge_inputs(const PoseCorrection& correction, FrameReport& report);
  [[nodiscard]] double doubt_of_steps() const;
  [[nodiscard]] StepFit fit_steps() const;
  void open_steps(const StepSize& size);
  void open_clock();
  void take_start(const InitialState& initial);
  void open_clock_of_start(const InitialState& initial);
  bool follow_clock_of_start();
  bool follow_clock(const FrameReport& report);
  void set_clock_offset(std::int64_t offset_ns);
  void restart_steps();
  [[nodiscard]] bool is_broken() const;
  void begin_anew();
  void restart_monitor();
  std::size_t forget(const StereoFrame& frame);
  std::size_t forget_all();
  [[nodiscard]] std::size_t forget_after_blindness(const StereoFrame& frame);
  [[nodiscard]] bool initializes_before_update() const;
  [[nodiscard]] LinearizationPoint choose_linearization_point(const StereoFrame& frame) const;
  [[nodiscard]] NewLandmarks initialize_landmarks(Estimate& estimate, const StereoFrame& frame,
                                                  const MountedRig& rig) const;
  [[nodiscard]] StackedFrame stack(const Estimate& estimate, const StereoFrame& frame,
                                   const LinearizationPoint& at, const NewLandmarks& new_landmarks,
                                   FrameReport& report) const;
  struct Relocated {
    StackedFrame stacked;
    bool found = false;  ///< the rounds settled where most points agree
  };
  [[nodiscard]] Relocated stack_where_seen(const StereoFrame& frame, const LinearizationPoint& at,
                                           NewLandmarks new_landmarks, const ParameterErrorModel& model,
                                           FrameReport& report) const;
  [[nodiscard]] bool is_after_darkness(std::int64_t t_ns) const;
  [[nodiscard]] ParameterErrorModel gate_model(const ParameterErrorModel& model) const;
  /// @return one flag per stacked point
  [[nodiscard]] std::vector<bool> gate_points(const StackedFrame& stacked, const FrameInnovation& seen,
                                              const ParameterErrorModel& model, FrameReport& report) const;
  [[nodiscard]] Attempt attempt(const StereoFrame& frame, const LinearizationPoint& at,
                                const ParameterErrorModel& model, bool iterated, FrameReport& report);
  [[nodiscard]] bool relocate(const StereoFrame& frame, const MountedRig& rig);
  [[nodiscard]] Attempt attempt_after_darkness(const StereoFrame& frame, const LinearizationPoint& at,
                                               const ParameterErrorModel& model, FrameReport& report);
  [[nodiscard]] bool leads_astray(const StereoFrame& frame, const ParameterErrorModel& model,
                                  Attempt& attempt) const;
  [[nodiscard]] UpdateReport correct_covariance(Attempt& attempt, const ParameterErrorModel& model);
  void constrained_update(Attempt& attempt, const ParameterErrorModel& model, double dt, FrameReport& report);
  void record(const StackedFrame& stacked, const std::vector<bool>& accepted,
              const NewLandmarks& new_landmarks, FrameReport& report);

  void copy_state(const StereoFilter& constrained);
  [[nodiscard]] Eigen::MatrixXd linearization_prior() const;
  [[nodiscard]] MountedRig mounted(const StereoCalibration& calibration) const;
  [[nodiscard]] StereoCalibration calibration_of(const Estimate& estimate) const;
  void use_estimated_calibration();
  [[nodiscard]] ParameterErrorModel error_model() const;
  void renew_mount(double dt);
  [[nodiscard]] BearingWalk bearing_walk() const;
  void walk_parameters(double dt);
  void notice_motion();
  [[nodiscard]] PredictedState with_doubtful_lengths(PredictedState state) const;
  /// Of the map's scale as it is, where what tells it is noise, or of odometry's speeds: what pixels say of
  /// them are errors of lenses and of linearising. Else nothing.
  [[nodiscard]] std::optional<Estimate::Considered> scale_to_hold() const;
  /// Whether a length of the baseline can be learned.
  [[nodiscard]] bool tells_length() const { return has_scale(options_.motion) && scale_told_; }
  void learn_from(const ParameterErrorModel& model, const UpdateReport& update, double dt,
                  FrameReport& report);
  /// A frame accused the rig a moment ago, which this filter trusts.
  [[nodiscard]] bool seems_misled(std::int64_t t_ns) const;
  [[nodiscard]] bool points_quarrel(const FrameReport& report) const;
  void learn_noise(const ParameterErrorModel& model, const UpdateReport& update,
                   const PoseCorrection& correction, const FrameReport& report);
  [[nodiscard]] PixelNoise sigma_px() const {
    return pixel_noise_ ? pixel_noise_->sigma_px() : options_.sigma_px;
  }
  [[nodiscard]] std::optional<ParameterEvidence> gathered(const ParameterErrorModel& model) const;

  NavigatorOptions options_;
  StereoCalibration given_;        // as assumed at the start
  StereoCalibration calibration_;  // the one in use
  RigParameters scale_;            // one plausible error of theta of the calibration that was given
  Estimate estimate_;
  GateThresholds gate_thresholds_;
  LandmarkBudget budget_;
  MovingTracks moving_;
  UsualScatter usual_scatter_;
  InputBuffer inputs_;
  InputChecks checks_;
  std::size_t late_ = 0;  // samples since the last frame
  bool postpones_epoch_ = false;
  bool has_processed_ = false;  // a frame: from then on what is older than the state comes too late
  InputAlarm input_alarm_;
  std::int64_t steps_ns_ = 0;                    // steps of biases and clock are supposed to have begun then
  bool doubts_clock_ = false;                    // a frame contradicted the inputs, and no step explains it
  std::optional<std::int64_t> clock_opened_ns_;  // it may have stepped: its step is estimated
  bool clock_of_start_ = false;                  // it is open since the start, until it is known
  std::int64_t clock_offset_ns_ = 0;             // of an IMU's stamps, beside when its samples were taken
  MoreNoise distrust_;                           // what the images said against the inputs, for a while
  std::int64_t trusted_again_ns_ = std::numeric_limits<std::int64_t>::min();
  double blind_turn_ = 0.0;  // variance of attitude that predictions added since the last update [rad^2]
  InitialState sound_;       // body after the last sound frame, to begin anew from
  std::optional<ScaleExcitation> excitation_;  // where nothing but the IMU tells the scale
  bool scale_told_;  // the start knew how long a metre is, or a motion has told it since
  Eigen::Vector3d omega_input_ = Eigen::Vector3d::Zero();  // [rad/s], of the last step: gyro or odometry
  std::optional<LearnedPixelNoise> pixel_noise_;           // where nobody stated it
  std::optional<std::int64_t> rig_accused_ns_;             // by a frame, last: it explains what is off
  std::optional<LearnedImuNoise> imu_noise_;               // beside what was stated, if that is asked for
  std::optional<LearnedImuNoise> motion_noise_;            // the same of accelerations that no input shows
  std::optional<LearnedOdometryNoise> odometry_noise_;     // where nobody stated it
  std::optional<HealthMonitor> monitor_;
  std::optional<HealthReport> last_health_;
  WhiteSize fresh_;  // adaptive: zero as long as theta is trusted
  std::int64_t last_frame_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t last_points_ns_ = std::numeric_limits<std::int64_t>::min();  // of a frame that shows any
};

}  // namespace limber
