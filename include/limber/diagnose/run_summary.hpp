// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/datasets/recording.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/diagnose/offset_mistakes.hpp"
#include "limber/diagnose/readout_watch.hpp"
#include "limber/diagnose/scale_check.hpp"
#include "limber/evaluate/alignment.hpp"
#include "limber/evaluate/world_tilt.hpp"
#include "limber/run/input_summary.hpp"
#include "limber/run/run_recording.hpp"

namespace limber {

/// Quantiles of a time per frame [ms].
struct FrameTime {
  /// median, 99 % quantile and maximum [ms]
  double p50 = 0.0, p99 = 0.0, worst = 0.0;
};

/// What an image front end did in a run. End to end: reading, tracking and filtering a frame, one after the
/// other.
struct FrontendSummary {
  /// reading, following and matching, all with the filter
  FrameTime decode, track, end_to_end;
  double left_points = 0.0, right_points = 0.0;  ///< per frame
  double frames_per_track = 0.0;                 ///< mean
};

/// Figures of merit of a run; what is not known is empty. Definitions: docs/formats-results.md.
struct RunSummary {
  /// names
  std::string method, dataset;
  /// that the run went through
  std::size_t frames = 0;
  /// from the first to the last of them [s]
  double duration_s = 0.0;
  double path_length_m = 0.0;  ///< of the truth if known, else of the estimate
  /// RMSE of position [m] without alignment, after SE(3), after Sim(3), and the latter's scale [-]
  std::optional<double> ate_none_m, ate_se3_m, ate_sim3_m, scale;
  /// over all frames, after `alignment`
  std::optional<double> position_rmse_m, attitude_rmse_deg;
  std::optional<double> position_final_m, attitude_final_deg;  ///< after the last frame, aligned as the RMSE
  std::optional<double> position_max_m, attitude_max_deg;      ///< of any frame
  /// NEES per d.o.f. of pose, position, attitude; 1 = consistent
  std::optional<double> anees, anees_position, anees_attitude;
  std::optional<double> anees_scale;      ///< of the distance from the begin, see distance_nees
  std::optional<double> share_within_95;  ///< of the frames of anees, see Consistency
  std::size_t frames_refused = 0;         ///< of those frames: pose covariance not positive definite
  double nis = 0.0, nis_dof = 0.0;        ///< sums over all updates
  /// their quotient; 1 = consistent
  std::optional<double> nis_per_dof;
  double ms_per_frame_mean = 0.0, ms_per_frame_p50 = 0.0, ms_per_frame_p99 = 0.0, ms_per_frame_p999 = 0.0,
         ms_per_frame_worst = 0.0;  ///< filter alone, of the frames that it saw
  /// Time that a start from the sensors took, in all and in the longest of its frames; nothing where no
  /// frame was spent on one.
  std::optional<double> start_ms, start_worst_ms;
  std::optional<FrontendSummary> frontend;  ///< nothing for matched points
  double realtime_factor = 0.0;             ///< duration over time spent, front end included
  /// largest resident memory of the process [MB]
  double peak_rss_mb = 0.0;
  /// over all frames
  std::size_t points_refused = 0;
  /// mean
  double points_per_frame = 0.0;
  /// statuses and events
  InputSummary inputs;
  std::optional<HealthSummary> health;  ///< nothing where nothing was watched (mono-left)
  std::optional<ReadoutTime> readout;   ///< as the frames show it; nothing where they do not, see add_readout
  /// The frames show another readout time than was assumed: what the run says of itself is not to be
  /// believed.
  bool readout_contradicted = false;
  /// A clock that is off may be why the rig looks as it does: it is not judged, see add_offsets.
  bool clocks_hide_rig = false;
  std::vector<std::string>
      mistakes;  ///< of the calibration or of units, in words: no verdict on the rig beside them
  std::vector<std::string> clock_mistakes;         ///< clocks that are off, in words
  std::optional<std::string> corrected_clock;      ///< one that is off, and was corrected, in words
  std::vector<OffsetMistake> camera_imu_mistakes;  ///< beside clocks that are off
  /// The method takes the length of the baseline for exact, and positions rest on it (but with odometry,
  /// which shows its metre in every sample); see add_scale_check.
  bool rests_on_length = false;
  std::optional<ScaleCheck> scale_check;  ///< nothing where that is not so, or nothing shows the scale
  /// What was taken out before position_rmse_m, attitude_rmse_deg and anees: "nothing", "position and yaw of
  /// the first pose", the same after "the tilt of the truth's world", or "whole first pose"; empty without
  /// truth.
  std::string alignment;
  /// How far the truth's vertical is from that of the estimate, mean over the run [deg]; nothing without
  /// truth, and where nothing shows what is down or the truth itself was the start.
  std::optional<double> truth_tilt_deg;
  bool truth_is_level = true;  ///< false: that tilt was taken out (WorldTilt::is_askew)
  /// The truth at the times of the frames that have one, in the world of the estimate (so aligned).
  std::vector<StampedPose> truth;
  /// The same with velocity and biases as far as the recording knows them; empty if it knows none.
  GroundTruth truth_motion;
};

/// What is taken out of an estimate before its errors are counted, and how that is called.
struct StartAlignment {
  Alignment alignment;  ///< rigid
  /// "nothing", "position and yaw of the first pose" or "whole first pose"
  std::string in_words;
};

/// start_alignment with position and yaw of the first pose, by its name.
inline constexpr std::string_view kFirstPoseAlignment = "position and yaw of the first pose";

/// What is taken out where the world of the truth is not level. @param poses  not empty
[[nodiscard]] StartAlignment upright_alignment(std::span<const MatchedPose> poses, const WorldTilt& tilt);

/// Nothing for a start from the truth. For one from the sensors, the first pose: its position and yaw where
/// an IMU shows what is down, all of it where nothing does. @param poses  not empty
[[nodiscard]] StartAlignment start_alignment(std::span<const MatchedPose> poses, StartMode start,
                                             MotionModel motion);

/// @brief Takes in how long the frames of a run show the rows to take. Where that contradicts the calibration
/// it is the first of the notes, and the rig is not judged: rows with times of their own look like one that
/// bends.
void add_readout(const std::optional<ReadoutTime>& readout, const StereoCalibration& assumed,
                 RunRecord& record, RunSummary& summary);

/// Whether the run's poses are as good as it says of them, as far as it knows: it is not lost, and no mistake
/// was found that its sigmas do not hold.
[[nodiscard]] bool is_trustworthy(const RunSummary& summary);

/// @brief Takes in what the frames of a run show of its clocks and of the cameras' mount. A rig that looks
/// wrong where a clock may be why is not judged, one that is `ok` on a mount that is turned is `degraded`:
/// see verdict_beside.
void add_offsets(const SensorOffsets& offsets, RunSummary& summary);

/// @brief Asks what the IMU alone shows of the scale of a run whose method takes the length of the baseline
/// for exact, and judges the rig anew by that: the filter's own windows agree with whatever length it trusts.
/// Where nothing shows it, and for stretches of the run that were over by then, that length is not known.
/// Nothing of a run that is lost.
void add_scale_check(const Recording& recording, const RunOptions& options, const RunRecord& record,
                     RunSummary& summary);

/// @brief Judges a run against the recording's ground truth, where it has one.
/// position_rmse, attitude_rmse and anees are unaligned for a ground truth start; else the estimate is first
/// aligned at the first pose: by position and yaw where an IMU shows what is down, by the whole pose where
/// nothing does. Where an IMU shows that the world of the truth is not level, that tilt is taken out before.
[[nodiscard]] RunSummary summarize(const Recording& recording, const RunOptions& options,
                                   const RunRecord& record);

}  // namespace limber
