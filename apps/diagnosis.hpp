// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "limber/diagnose/depth_effect.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/diagnose/offset_mistakes.hpp"
#include "limber/diagnose/pose_loss.hpp"
#include "limber/diagnose/readout_watch.hpp"
#include "limber/run_files/health_state.hpp"

/// What `limber health` says: as an exit code, in plain words, and as JSON.
namespace limber::app {

inline constexpr int kExitDecalibrated = 3, kExitCannotTell = 4, kExitDegraded = 5;

/// Against an earlier recording.
struct SinceThen {
  std::string recording;
  CalibrationState change;
};

struct Diagnosis {
  std::string dataset;
  std::size_t frames = 0, frames_of_recording = 0;
  bool stopped = false;  ///< before the last frame: all of this is of those before
  double duration_s = 0.0;
  std::optional<double> lost_since_s;  ///< since the first frame; the verdict is that of lines alone then
  WatchOptions judged_by;
  std::optional<double> nis_per_dof;
  std::optional<HealthSummary> health;  ///< nothing if the run failed, or no frame could be judged
  std::vector<DepthEffect> depths;      ///< of the present state
  bool metric = true;                   ///< something shows a metre; else the baseline's length is trusted
  std::optional<HealthState> state;     ///< to be kept for later recordings
  std::optional<SinceThen> since;       ///< if there was an earlier one to compare with
  std::optional<PoseLoss> pose;         ///< of ekf beside lcekf
  std::string ekf_failure;              ///< why there is no ekf beside it; empty if it did not fail
  std::vector<std::string> mistakes;    ///< of the calibration, see calibration_mistakes
  SensorOffsets offsets;                ///< not asked where there are mistakes
  std::optional<ReadoutTime> readout;   ///< of cam0, as the frames show it
  std::string
      readout_contradicted;  ///< why the rig cannot be judged: another readout than was assumed; else empty
  std::string failure;       ///< why the run failed; empty if it did not
};

/// That of the calibration; `decalibrated` if a mistake was found; else `cannot tell` where the rows of the
/// images are not exposed as assumed, which looks like a rig that bends, or where the rig looks wrong and a
/// clock may be why.
[[nodiscard]] HealthVerdict verdict_of(const Diagnosis& diagnosis);

/// 0, 3, 4 or 5.
[[nodiscard]] int exit_code(HealthVerdict verdict);

[[nodiscard]] std::string to_text(const Diagnosis& diagnosis);
[[nodiscard]] std::string to_json(const Diagnosis& diagnosis);

}  // namespace limber::app
