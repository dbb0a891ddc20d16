// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "limber/health/change_test.hpp"
#include "limber/health/rig_movement.hpp"
#include "limber/health/rig_window.hpp"
#include "limber/health/tolerance.hpp"

namespace limber {

/// How a calibration is judged.
struct WatchOptions {
  /// what is ok, and what is of no use any more
  Tolerance tolerance{};
  double window_s = 2.5;               ///< > 0
  double false_alarms_per_hour = 0.1;  ///< of changes, of a rig that does not change; > 0
};

/// How the rig's error grew over a stretch of windows.
struct RigDrift {
  RigEstimate change;     ///< from the first window to the last
  double seconds = 0.0;   ///< between their middles
  std::size_t named = 0;  ///< the axis that explains it best
};

/// Fewer are too few to judge a rig by; its depths, by tracks whose own depth is known from motion.
inline constexpr std::size_t kFewestTracks = 30;

/// What is known of the calibration since it changed last.
struct CalibrationState {
  std::int64_t from_ns = 0, to_ns = 0;  ///< first and last frame
  /// the worst of what follows
  HealthVerdict verdict = HealthVerdict::kCannotTell;
  /// from the two effects alone
  HealthVerdict by_epipolar = HealthVerdict::kCannotTell, by_depth = HealthVerdict::kCannotTell;
  std::array<HealthVerdict, 6> axes{};  ///< ax, ay, az, tx, ty, tz
  std::array<Band, 6> bands{};          ///< of the axes [rad, m]
  Eigen::Index vergence = 1;            ///< vergence_axis() of the rig
  std::optional<std::size_t> named;     ///< the axis that explains best what is degraded or decalibrated
  /// Of vision alone: the windows find a baseline that is half as long as assumed, or less, or half as long
  /// again. The scale of the trajectory is gone, and no depth can be told.
  bool scale_is_lost = false;
  /// true minus assumed theta, with its covariance
  RigEstimate estimate;
  BetaEstimate whole;  ///< what `estimate` is a part of
  /// what that does to points and depths
  CalibrationEffect effect;
  /// The error grew from the first window on, beyond doubt; `estimate` is that of the last one.
  std::optional<RigDrift> drift;
  RigMovement movement;          ///< about the mean, from frame to frame
  DepthMovement depth_movement;  ///< the same, by what it does to depths
  /// from either movement alone
  HealthVerdict by_movement = HealthVerdict::kCannotTell, by_depth_movement = HealthVerdict::kCannotTell;
  /// what the estimate rests on; deep: points whose depth is known from motion, and their tracks
  std::size_t windows = 0, tracks = 0, points = 0, deep = 0, deep_tracks = 0;

  /// From frame to frame, by more than what is ok.
  [[nodiscard]] bool moves() const;
  /// The axis that does so most.
  [[nodiscard]] std::size_t moving_axis() const;
};

/// @brief The state at the end of a stretch of windows. With five or more the error is a line over time: of
/// any rate, where that explains the windows better (p < 1 %) and by more than half of what the tolerance
/// calls ok; else of one that changes it by no more than that. It is said to drift where that is no chance
/// (`false_alarms_per_hour`), and goes on being said while its line explains the windows better.
/// @param chosen  first windows by which a change was found: they were chosen for being different, so that
///                their way back would look like a drift. They say nothing of one
/// @param drifts  it was said to a window ago
[[nodiscard]] CalibrationState state_of(const std::vector<RigEvidence>& windows, const RigParameters& theta,
                                        bool metric, const WatchOptions& options, std::size_t chosen = 0,
                                        bool drifts = false);

/// @brief Fills in what follows from an estimate: effect, bands and verdicts. With fewer than 30 tracks
/// (`out.tracks`) nothing can be told. With fewer whose depth is known (`out.deep_tracks`) neither depths nor
/// vergence are, and epipolar lines are as they would be with the assumed one. Where vision alone has lost
/// its scale (`out.scale_is_lost`) epipolar lines and angles tell, depths and lengths do not.
void judge_estimate(const BetaEstimate& estimate, const RigParameters& theta, bool metric,
                    const Tolerance& tolerance, CalibrationState& out);

/// How wrong the scale of a trajectory is, by what shows it without the rig.
struct TrajectoryScale {
  /// share of its lengths by which these are too long
  double too_long = 0.0;
  /// of that; 0.5: nothing shows it
  double sigma = 0.5;
};

/// @brief The same state, where a filter that trusts the length of the baseline has watched. Such a filter
/// takes the scale of its trajectory from that length, so that windows agree with both: what they say of the
/// length is worth what is known of that scale without the rig.
[[nodiscard]] CalibrationState with_scale(const CalibrationState& state, const TrajectoryScale& scale,
                                          const RigParameters& theta, const Tolerance& tolerance);

/// After a window.
struct CalibrationReport {
  CalibrationState state;   ///< since the last change
  CalibrationState window;  ///< of this window alone
  /// Since this window changes are known: what was before each of them, in order.
  std::vector<CalibrationState> past{};
};

/// What the trajectory that the points are seen from is worth.
struct TrajectoryQuality {
  bool sound = true;  ///< inputs were sound, and images agreed with them
  /// Of the speed and its error [m^2/s^2]: what they say of the length of a metre. Zero: nothing.
  double speed_squared = 0.0, speed_variance = 0.0;
};

/// @brief Judges the calibration while it goes: per window, and since it changed last.
///
/// A change: the last two to five windows differ from those before, in depth or in one of the main ways to
/// leave the epipolar lines, by more than chance (steps of that length seen earlier, `false_alarms_per_hour`)
/// and by more than half of what the tolerance calls ok; those before may themselves have been in two states.
/// The window that holds the change belongs to neither. From there on evidence gathers anew, and the verdict
/// is that of the new state.
/// @note docs/derivations/health.md
class CalibrationWatch {
 public:
  /// @param metric  inputs say how long a metre is
  /// @throws std::invalid_argument if an option makes no sense
  CalibrationWatch(const WatchOptions& options, const StereoCalibration& assumed, bool metric);

  /// @brief The next frame, and a slice of the work on the window before.
  ///
  /// What a window says is known a second or two after its end, so that no frame waits for it: with each of
  /// the frames that follow half a millisecond of it is done.
  /// @param T_world_cam0  of the filter that watches
  /// @param quality       of that pose
  void add(const StereoFrame& frame, const Pose& T_world_cam0, const TrajectoryQuality& quality);

  /// What the windows say whose slices are done; null before there is one. The first is also looked at while
  /// it grows. The same object until more is known.
  [[nodiscard]] const std::shared_ptr<const CalibrationReport>& report() const { return report_; }
  /// The same of all windows that are over: does what waits to be done first, some milliseconds, once for
  /// each window. The same object as report() has when its slices are done.
  [[nodiscard]] std::shared_ptr<const CalibrationReport> report_at_once() const;

 private:
  struct Pending {
    WindowFit fit;
    double scale_sigma;
    bool ends;  // the window is over; else an early look at it
  };

  [[nodiscard]] Pose steadied(const Pose& T_world_cam0, const TrajectoryQuality& quality);
  void advance();
  void finish();
  void end_window(const RigEvidence& evidence);
  /// First windows of the states since the first one.
  [[nodiscard]] std::vector<std::size_t> changes();

  WatchOptions options_;
  RigParameters theta_;
  bool metric_;
  RigWindow collecting_;
  std::optional<Eigen::Vector3d> last_place_;           // of the camera, as it was given
  Eigen::Vector3d trembled_ = Eigen::Vector3d::Zero();  // so far, where it did not move
  double speed_squared_ = 0.0, speed_variance_ = 0.0;   // sums over the window
  std::size_t looks_ = 0;                               // at the first window
  std::optional<Pending> pending_;                      // what the last window, or the last look, says
  std::vector<RigEvidence> windows_;                    // since the last change
  std::size_t chosen_ = 0;                              // of these, by which that change was found
  EarlierSteps earlier_;                                // of this state and those before
  std::shared_ptr<const CalibrationReport> report_;
  /// What report_ becomes by what is pending, where that was asked for.
  mutable std::optional<std::shared_ptr<const CalibrationReport>> report_to_come_;
};

}  // namespace limber
