// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "limber/health/calibration_watch.hpp"
#include "limber/health/health_monitor.hpp"
#include "limber/health/input_alarm.hpp"
#include "limber/predict/input_checks.hpp"
#include "limber/sensors/parameters.hpp"
#include "limber/stack/stack_frame.hpp"
#include "limber/update/update.hpp"

namespace limber {

/// What the prediction to a frame rested on; the worst that holds.
enum class InputStatus : std::uint8_t {
  kNotNeeded,     ///< the motion model has no inputs
  kSound,         ///< samples all the way
  kFaulty,        ///< some samples were left out or doubted, see InputReport::faults
  kGap,           ///< for a while no sample: what could have happened counts as noise
  kContradicted,  ///< the images say that the samples were wrong: velocity and biases were opened anew
  kNone           ///< there has never been a sample
};

/// "not needed", "sound", "faulty", "gap", "contradicted", "none".
[[nodiscard]] std::string to_string(InputStatus status);
/// "updated", "no points", "singular".
[[nodiscard]] std::string to_string(UpdateStatus status);
/// "stuck", "spike", "saturated", "impossible", "late".
[[nodiscard]] std::string to_string(InputFault fault);

/// The inputs since the frame before.
struct InputReport {
  /// the worst that holds since the frame before
  InputStatus status = InputStatus::kNotNeeded;
  double gap_s = 0.0;       ///< longest gap that the frame lies in or after, as far as it is known
  InputFaultCounts faults;  ///< samples with each fault
  std::optional<InputContradiction> contradiction;  ///< what the images said against them
  /// How far the images corrected what the inputs predicted: chi-square of 6 degrees of freedom, for a filter
  /// that no calibration can lead astray; 0 where nothing was tested.
  double chi2 = 0.0;
};

/// @param faults  samples since the frame at begin_ns
[[nodiscard]] InputReport report_on(const InputBuffer& inputs, const InputFaultCounts& faults,
                                    std::int64_t begin_ns, std::int64_t end_ns);

/// What became of one frame.
struct FrameReport {
  /// [ns]
  std::int64_t t_ns = 0;
  UpdateStatus status = UpdateStatus::kEmpty;  ///< unless it is kUpdated, the frame corrected nothing
  /// since the frame before
  InputReport inputs;
  bool reset = false;     ///< the filter had broken down and began anew, see StereoFilter::process
  double sigma_px = 0.0;  ///< pixel noise that the frame was taken with, rms of u0, v0, u1, v1 [px]
  /// IMU noise that the frame was predicted with, over what was stated; where nothing measures the motion,
  /// how much livelier than the constant-velocity model it is taken for
  ImuNoiseFactors imu_noise;
  double nis = 0.0;       ///< of the projected rows [-]
  Eigen::Index dof = 0;   ///< of nis
  Eigen::Index rank = 0;  ///< constrained directions that this frame's geometry can see
  /// points that came with the frame
  std::size_t observed = 0;
  std::size_t used = 0;         ///< points of the update; zero if there was none
  std::size_t initialized = 0;  ///< new in the map
  /// landmarks that left the map
  std::size_t removed = 0;
  bool gate_overruled =
      false;  ///< the gate would have refused most points, so it refused none but gross outliers
  /// The gate refused most points, of something that moves: the others agree with the inputs, and the two are
  /// not of one rigid world. These tracks are left out for MovingTracks::kLeftOut.
  bool most_move = false;
  /// The gate refused most points, of which no pose and no calibration explains half: mismatches.
  bool most_mismatched = false;
  /// After the frame's correction its points would have been farther from where they are seen than before: it
  /// was not made, and they were taken for new ones.
  bool led_astray = false;
  std::optional<double> scatter{};  ///< see GateReport::scatter
  double correction = 0.0;          ///< of position or attitude, the larger, in sigmas of the prediction [-]
  /// points that were not used, and why
  std::vector<Refusal> refused;
  std::optional<HealthReport> health;  ///< of the alarm, if watched; the verdict is `calibration`
  /// What is known of the calibration, if watched and a window is over; the same object until the next is.
  std::shared_ptr<const CalibrationReport> calibration;
  /// What the frame says against the rig that the filter takes for true (ekf-full, adaptive: its estimate).
  /// Nothing while an input fault is active: the rig is not to blame.
  std::optional<HealthInput> evidence;
};

/// What a filter has learned of the calibration that it was given.
struct CalibrationEstimate {
  ParameterSet parameters;                          ///< those it estimates; the others are zero below
  ParameterVector error = ParameterVector::Zero();  ///< true minus given
  ParameterVector sigma = ParameterVector::Zero();  ///< standard deviation of that
  /// `adaptive` takes the rig for exact so far: its sigma is what it takes for granted, not what it knows
  bool trusts_rig = false;
};

/// Those of an estimate that the sensors have told: not a rig that is trusted.
[[nodiscard]] ParameterSet told_parameters(const CalibrationEstimate& estimate);

}  // namespace limber
