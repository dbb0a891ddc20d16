// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace limber {

/// A run that came to nothing: its figures are unknown, and it enters no average.
struct Divergence {
  std::size_t frame =
      0;  ///< stereo frame (0 is the first) that could not be finished, or after which the state is absurd
  double t = 0.0;      ///< [s] since the start of the recording
  std::string reason;  ///< in plain words
};

/// Figures of merit of one run of one method. Definitions as in summary.json, docs/formats-results.md:
/// nothing is aligned after a start from the truth, the first pose after one from the sensors. What is not
/// known is empty.
struct RunFigures {
  /// over all frames
  std::optional<double> position_rmse_m, attitude_rmse_deg;
  std::optional<double> position_final_m, attitude_final_deg;  ///< error after the last frame
  std::optional<double> position_max_m, attitude_max_deg;      ///< largest error of any frame
  std::optional<double> landmark_rmse_m;                       ///< over the final map
  /// RMSE of position [m] without alignment, after SE(3), after Sim(3), and the latter's scale [-]
  std::optional<double> ate_none_m, ate_se3_m, ate_sim3_m, scale;
  std::optional<double> anees, anees_position,
      anees_attitude;                 ///< per d.o.f., mean over frames later than 1 s
  std::optional<double> anees_scale;  ///< the same of the distance from the begin, see distance_nees
  std::optional<double>
      share_within_95;  ///< of those frames, pose NEES below the 95 % quantile of chi-square(6)
  std::optional<std::int64_t> frames_refused;  ///< of those, without NEES: covariance not positive definite
  std::optional<double> nis, nis_dof;          ///< sums over all updates
  /// of the truth [m]; mean
  std::optional<double> path_length_m, points_per_frame;
  /// that went through; over all of them
  std::optional<std::int64_t> frames, points_refused;
  std::optional<double> start_s;  ///< from the first frame until a start from the sensors was ready
  std::optional<double> lost_s;   ///< from the first frame until the run was lost; empty: it was not
  // Depend on the machine, and are no part of what has to be repeatable:
  std::optional<double> ms_per_frame_mean, ms_per_frame_p50, ms_per_frame_p99;  ///< filter alone [ms]
};

/// One row of a study.
struct StudyRun {
  /// its number, from 0
  std::uint64_t run = 0;
  /// nothing: it did not
  std::optional<Divergence> diverged;
  /// empty if it diverged
  RunFigures figures;
};

}  // namespace limber
