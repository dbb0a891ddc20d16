// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/evaluate/statistics.hpp"

/// @file
/// Runs beside each other, from the folders that write_run_output made. How: docs/compare.md.
namespace limber {

/// How runs are compared.
struct CompareOptions {
  /// Length of the pieces that relative errors are of [m]; nothing: a round length of which ten or more fit
  /// into the path, unless that takes less than a second.
  std::optional<double> piece_m;
  /// Compare runs piece by piece that assume different things of their recording, too.
  bool across_assumptions = false;
};

/// How a run ended.
enum class RunEnd : std::uint8_t {
  kDone,
  kPartial,  ///< it was stopped, or parts of its recording are missing
  kLost      ///< its inputs lost it, and nothing brought it back
};
/// "done", "partial", "lost".
[[nodiscard]] std::string to_string(RunEnd end);

/// A run with what its files say; what is not known is empty.
struct ComparedRun {
  /// that the run wrote
  std::filesystem::path folder;
  std::string label;  ///< unique: the method, or the folder where methods repeat
  /// names, as in summary.json
  std::string recording, method;
  /// how the run ended
  RunEnd end = RunEnd::kDone;
  std::optional<double> lost_since_s;  ///< since the first frame
  /// of the run, and what a whole run of the recording would have had
  std::size_t frames = 0, frames_of_recording = 0;
  double duration_s = 0.0, path_length_m = 0.0;  ///< of the truth if known, else of the estimate
  /// false: what needs the truth is empty
  bool has_truth = false;
  /// After the rigid fit of all positions; of a path that determines none, after the run's own alignment.
  std::optional<double> ate_m;
  std::optional<double> attitude_rmse_deg;     ///< after the run's own alignment
  double piece_m = 0.0;                        ///< of the relative errors [m]
  std::size_t pieces = 0;                      ///< disjoint
  std::optional<double> rpe_percent, rpe_deg;  ///< mean over the pieces: % of their length; deg a piece
  std::optional<double> scale_error_percent;   ///< of the estimate, from the fit with scale
  std::optional<double> anees;                 ///< of the pose, as in summary.json
  bool truth_is_tilted = false;                ///< the world of the truth is not level: that is taken out
  std::optional<std::string> verdict;          ///< on the calibration
  std::optional<double> ms_per_frame, ms_per_frame_p99;  ///< median and p99
};

/// "done", "partial: 80 of 160 frames", "partial: of a damaged recording", "lost since 3.2 s".
[[nodiscard]] std::string end_in_words(const ComparedRun& run);

/// What a difference says.
enum class Judgement : std::uint8_t { kBetter, kWorse, kCannotTell };
/// "better", "worse", "cannot tell".
[[nodiscard]] std::string to_string(Judgement judgement);

/// Of errors, so less is better; cannot tell where the interval holds zero or there is none.
[[nodiscard]] Judgement judge(const MeanInterval& difference);

/// "+1.5 (+0.4 to +2.5): worse": the mean, its interval to two digits of its half width, the judgement.
[[nodiscard]] std::string difference_in_words(const MeanInterval& difference);

/// A run against an earlier one of the same recording, over the frames that both have.
struct RunDifference {
  std::size_t run = 0, against = 0;      ///< indices of RunComparison::runs
  std::vector<std::string> assumptions;  ///< in which they differ, in words
  std::size_t frames = 0;                ///< in common
  /// Piece by piece, `run` minus `against`: RPE [% of the way], [deg a piece]. Nothing without truth, without
  /// a piece in common, and where assumptions differ unless asked for.
  std::optional<MeanInterval> rpe_percent, rpe_deg;
  /// Difference of the ATE [m]. One number a recording: there is no interval.
  std::optional<double> ate_m;
  /// How far the runs are apart, position and yaw of their first common pose put together: RMS, and at the
  /// end.
  double apart_rms_m = 0.0, apart_end_m = 0.0, apart_end_deg = 0.0;
};

/// What compare_runs finds.
struct RunComparison {
  /// in the order given
  std::vector<ComparedRun> runs;
  std::vector<RunDifference> differences;  ///< each run but the first of its recording
  std::vector<std::string> notes;          ///< what was not compared, and why
};

/// @brief The runs of which a list speaks: a folder without summary.json stands for the runs in it, by name.
/// @throws DataError if a folder is no run and holds none
[[nodiscard]] std::vector<std::filesystem::path> run_folders(std::span<const std::filesystem::path> paths);

/// @param folders  one or more, each of a run
/// @throws DataError if a file is missing or cannot be used
/// @throws std::invalid_argument if there is no folder, one comes twice, or piece_m is not positive
[[nodiscard]] RunComparison compare_runs(std::span<const std::filesystem::path> folders,
                                         const CompareOptions& options = {});

}  // namespace limber
