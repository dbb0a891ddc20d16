// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "limber/health/tolerance.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/update/evidence.hpp"

/// @file
/// The alarm: does the assumed calibration still explain what is seen? A sequential test with a stated
/// false-alarm rate, within frames. How wrong it is, and whether that matters: CalibrationWatch.
namespace limber {

/// One number to choose, and what it rests on.
struct HealthOptions {
  double false_alarms_per_hour = 0.1;  ///< of a sound rig; > 0
  /// Evidence is gathered over windows of this length [s]: what is too small for one frame.
  double window_s = 2.5;
  /// An axis with a larger standard deviation over a window than this cannot be judged [plausible errors:
  /// 0.1 deg, 5 % of the baseline].
  double resolution = 0.2;
  /// Real pixels have errors that a frame's points share (lenses, corners that lean), which look like a rig
  /// that wavers. The evidence of frames may scatter about its mean by up to this factor more than pixel
  /// noise explains, in variance, before that counts against the rig. 1: pixel noise is all there is.
  double most_dispersion = 4.0;
  /// A frame that rejects the rig by itself has to be followed by another one that says so, too: a rig that
  /// has moved stays moved, a match that is wrong is another one in the next frame. What was gathered with a
  /// frame that none confirms is forgotten.
  bool confirm_frames = false;
};

/// What one frame told the monitor.
struct HealthReport {
  /// [ns]
  std::int64_t t_ns = 0;
  /// of this frame and of what was gathered
  HealthVerdict verdict = HealthVerdict::kCannotTell;
  std::array<HealthVerdict, 6> axes{};          ///< ax, ay, az, tx, ty, tz
  RigParameters delta = RigParameters::Zero();  ///< true minus assumed theta, from this frame alone [rad, m]
  RigParameters sigma = RigParameters::Zero();  ///< its standard deviation [rad, m]
  RigParameters gathered_delta = RigParameters::Zero();  ///< since `gathered_since_ns` [rad, m]
  RigParameters gathered_sigma = RigParameters::Zero();  ///< its standard deviation [rad, m]
  /// first frame of that [ns]
  std::int64_t gathered_since_ns = 0;
  double p_value = 1.0;                    ///< of this frame alone
  double gathered_p_value = 1.0;           ///< of what was gathered
  bool alarm = false;                      ///< a test rejects in this frame
  std::optional<std::int64_t> changed_ns;  ///< decalibrated: since when
};

/// What a filter hands over after a frame.
struct HealthInput {
  /// [ns], of the frame
  std::int64_t t_ns = 0;
  Eigen::MatrixXd directions;  ///< B: 6×k, columns of one plausible error each
  ParameterEvidence frame;     ///< about beta, from this frame's innovation
  /// About a constant beta, since the last restart, if the filter keeps a witness; else the monitor adds up
  /// the frames, which is right where innovations are white (a filter that trusts its calibration).
  std::optional<ParameterEvidence> gathered;
  double nis = 0.0;  ///< of the rows that theta does not touch [-]
  double dof = 0.0;  ///< its degrees of freedom
};

/// @brief Watches the part of the innovation that only a wrong calibration explains.
///
/// What frames scatter beyond pixel noise, up to a limit, and how long they stay on one side, is learned from
/// how they deviate from the mean of their window.
/// Two tests share the false-alarm rate: each frame's evidence, and that gathered over a window, tested five
/// times while it grows. Under a sound calibration both are chi-square, so their thresholds follow from the
/// rate alone. Both are measured against the noise that the other rows show (NIS / dof), so that a wrong
/// sigma_px raises no alarm.
/// @note docs/derivations/health.md
class HealthMonitor {
 public:
  /// @throws std::invalid_argument if a number is not positive and finite
  explicit HealthMonitor(const HealthOptions& options, double baseline);

  /// The next frame in time; says what the alarm makes of it, and whether the gathered evidence restarts().
  [[nodiscard]] HealthReport judge(const HealthInput& input);

  /// The gathered evidence is to be begun anew: after a window or an alarm.
  [[nodiscard]] bool restarts() const { return restarts_; }

  /// The last frame rejects the rig, and the next one has to confirm it.
  [[nodiscard]] bool is_unconfirmed() const { return unconfirmed_.has_value(); }

 private:
  struct Offset {
    RigParameters delta, sigma;
  };

  [[nodiscard]] double noise() const;
  [[nodiscard]] double p_value(const ParameterEvidence& evidence, double dispersion) const;
  [[nodiscard]] Offset offset(const ParameterEvidence& evidence, const Eigen::MatrixXd& directions,
                              double dispersion) const;
  void gather(const HealthInput& input);
  void scatter(const ParameterEvidence& frame);
  [[nodiscard]] double dispersion() const;
  [[nodiscard]] double dispersion_of_window() const;
  void test(const HealthInput& input, const Offset& frame, const Offset& gathered, HealthReport& report);
  [[nodiscard]] bool frame_rejects(const HealthInput& input, double limit, HealthReport& report);
  void name_axes(const Offset& offset, double threshold);
  [[nodiscard]] HealthVerdict verdict_of_axis(Eigen::Index axis, const RigParameters& sigma) const;
  [[nodiscard]] HealthVerdict verdict(const HealthReport& report) const;

  HealthOptions options_;
  RigParameters scale_;            // one plausible error
  ParameterEvidence gathered_;     // since gathered_since_ns_
  RigParameters sigma_of_window_;  // of the last whole window
  double nis_ = 0.0, dof_ = 0.0;
  std::vector<Eigen::VectorXd> whitened_;  // beta_hat of the window's frames in units of their noise
  // Over past windows, about the mean of each: sums of squares and of products of neighbours, and the largest
  // mean square.
  double squares_ = 0.0, products_ = 0.0;
  std::optional<double> largest_scatter_;
  std::int64_t last_ns_ = 0, gathered_since_ns_ = 0;
  std::size_t looks_ = 0;  // at the present window, so far
  bool started_ = false, restarts_ = false, suspect_ = false;
  std::optional<HealthReport> unconfirmed_;  // of a frame that rejects, which the next one has to confirm
  std::optional<std::int64_t> changed_ns_;   // decalibrated since
  std::array<bool, 6> named_{};
};

}  // namespace limber
