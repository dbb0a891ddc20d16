// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "limber/datasets/recording.hpp"
#include "limber/datasets/trajectory_files.hpp"
#include "limber/initialize/sensor_start.hpp"
#include "limber/run/run_options.hpp"
#include "limber/run/shared_starts.hpp"

namespace limber {

/// The n-th stereo frame of a recording: matched points as they are, or images through a front end.
using FrameSource = std::function<StereoFrame(std::size_t)>;

/// Stereo frames of a recording, matched points or images.
[[nodiscard]] std::size_t frame_count(const SensorData& sensors);

/// Frame `n` of a recording with matched points. The recording must outlive the source.
[[nodiscard]] FrameSource matched_frames(const SensorData& sensors);

/// A frame of a run that is done.
struct ObservedFrame {
  /// pose and covariance after the frame
  const TrajectoryRow& row;
  /// what became of the frame
  const FrameReport& report;
  /// As it stands after the frame; null for the frames that a start from the sensors has used up, which no
  /// filter went through.
  const Navigator* navigator;
  const StereoFrame* frame;  ///< as the navigator saw it, cleaned; null where that is null
  double filter_ms;          ///< time in the filter [ms]; zero where that is null
};

/// A frame that a start from the sensors has taken in. Once it is ready each comes again as an ObservedFrame.
struct WaitingFrame {
  const StereoFrame& frame;   ///< cleaned
  const StartReport& report;  ///< after it: what is missing
  std::size_t number;         ///< how many the start has taken in with it
};

/// What a run tells and asks, each of it empty if nobody wants it. What they throw ends the run and passes
/// through.
struct RunCallbacks {
  std::function<void(std::size_t)> progress{};          ///< the number of frames done
  std::function<void(const ObservedFrame&)> observe{};  ///< every frame in turn
  std::function<void(const WaitingFrame&)> wait{};  ///< every frame before a start from the sensors is ready
  std::function<bool()> stop{};  ///< asked before every frame: true ends the run with what it has by then
};

/// What a filter took for the calibration after a frame.
struct CalibrationRow {
  /// [ns]
  std::int64_t t_ns = 0;
  /// true minus assumed, with its standard deviation
  CalibrationEstimate estimate;
};

/// What an image front end did, frame by frame.
struct FrontendRecord {
  std::vector<std::int64_t> t_ns;                 ///< of the frames
  std::vector<double> decode_ms, track_ms;        ///< time spent on reading and on tracking a pair [ms]
  std::size_t left_points = 0, right_points = 0;  ///< sums over the frames
  std::set<std::int64_t> tracks;                  ///< track_ids
  double earlier_ms = 0.0;                        ///< of these times: for a run before, which left its frames

  /// One frame more.
  /// @param decoding_ms,tracking_ms  time spent on its pair [ms]
  void add(const StereoFrame& frame, double decoding_ms, double tracking_ms);
};

/// What a run leaves behind.
struct RunRecord {
  std::vector<TrajectoryRow> trajectory;  ///< after each frame
  std::vector<FrameReport> frames;        ///< one per row of the trajectory
  std::vector<double> frame_ms;           ///< filter time per frame [ms], without the frame source
  std::size_t frames_of_start = 0;  ///< the first of them: no filter saw them, a start from the sensors did
  std::vector<double> source_ms;    ///< time in the frame source per frame [ms]
  /// Where frames came from images: of all frames that were read, those that the run left out as well.
  std::optional<FrontendRecord> frontend;
  double elapsed_s = 0.0;                               ///< from the first frame read to the last state
  std::map<std::int64_t, Eigen::Vector3d> landmarks;    ///< the final map, p_world_landmark [m]
  RigParameters theta = RigParameters::Zero();          ///< what the filter takes for the rig at the end
  RigParameters theta_assumed = RigParameters::Zero();  ///< what it was told of the rig [rad, m]
  std::vector<CalibrationRow> calibration;              ///< one per row of the trajectory, if it is estimated
  std::vector<std::string> notes;                       ///< choices made on the user's behalf, in plain words
  /// what drove the prediction
  MotionModel motion = MotionModel::kImu;
  InitialState start;                       ///< what the filter was told of its first state
  std::optional<StartReport> sensor_start;  ///< StartMode::kAuto: what was known by then, and when that was
  /// That of the IMU's clock which the start found; for those that the filter did see FrameReport::inputs.
  std::optional<StampJump> clock_step_of_start;
  /// Frames of the last 30 s, of those of the start as well, as the navigator saw them, where there is an IMU
  /// and the run is watched: enough to ask once more what the IMU shows.
  std::deque<StereoFrame> last_frames;
  /// What was learned of the pixels by the last frame; nothing where their noise was stated.
  std::optional<PixelNoiseReport> pixel_noise;
  std::optional<OdometryNoise> odometry_noise;  ///< the same of odometry: white, per sample
  /// How much noisier than stated the IMU was taken for, the usual of all frames; nothing where that is not
  /// learned.
  std::optional<ImuNoiseFactors> imu_noise;
  /// The same of a motion that nothing measures, over the constant-velocity model's.
  std::optional<ImuNoiseFactors> motion_noise;
  CleaningReport cleaning;  ///< what was taken out of the frames before the navigator saw them
  /// that a whole run would have had
  std::size_t frames_of_recording = 0;
  std::size_t frames_unreadable = 0;  ///< whose images could not be read: they had no points
  bool stopped = false;               ///< before the last frame, because the caller asked to
  bool recording_partial = false;     ///< Recording::partial: what is missing was not there to be run through

  /// Neither of both.
  [[nodiscard]] bool is_complete() const { return !stopped && !recording_partial; }
};

/// Adds what the front end behind the frame source did: source_ms becomes the work on each frame, where the
/// run has measured how long it waited for it. What an earlier run has spent on the frames counts, too.
void add_frontend(const FrontendRecord& frontend, RunRecord& record);

/// @brief Runs one method over a recording. Estimators see what a rig would deliver; the truth is used for
/// StartMode::kGroundTruth and for Method::kOracle only.
/// Frames before the first IMU or odometry sample are skipped, and said so.
/// @param shared  starts of other runs over the recording, and for others; null: this run solves its own
/// @throws std::invalid_argument if the recording cannot be run like that (no usable frame, no truth to start
/// from)
/// @throws DivergenceError if the filter's numbers are no estimate any more
[[nodiscard]] RunRecord run_recording(const Recording& recording, const RunOptions& options,
                                      const FrameSource& frames, const RunCallbacks& callbacks = {},
                                      SharedStarts* shared = nullptr);

}  // namespace limber
