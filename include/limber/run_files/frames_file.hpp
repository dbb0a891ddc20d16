// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "limber/navigate/frame_report.hpp"
#include "limber/run/run_recording.hpp"

namespace limber {

/// One line of a run's frames.csv.
struct FrameRow {
  /// [ns]
  std::int64_t t_ns = 0;
  std::size_t observed = 0, used = 0, initialized = 0, removed = 0, refused = 0;  ///< points
  /// see FrameReport::gate_overruled
  bool gate_overruled = false;
  double nis = 0.0;      ///< of the rows that entered [-]
  std::size_t dof = 0;   ///< of nis
  std::size_t rank = 0;  ///< constrained directions
  /// of the update
  UpdateStatus status = UpdateStatus::kEmpty;
  /// what the prediction rested on
  InputStatus inputs = InputStatus::kNotNeeded;
  double gap_s = 0.0;                       ///< longest gap of the inputs
  bool reset = false;                       ///< the filter had broken down
  double filter_ms = 0.0, source_ms = 0.0;  ///< time spent [ms]
  double sigma_px = 0.0;                    ///< see FrameReport::sigma_px; 0 in files of old
  double inputs_chi2 = 0.0;                 ///< see InputReport::chi2; 0 in files of old
  ImuNoiseFactors imu_noise;                ///< see FrameReport::imu_noise; 1 in files of old
};

/// What frames.csv says of a frame, but for the times spent.
[[nodiscard]] FrameRow frame_row(const FrameReport& report);

/// A line for each frame of the record. @throws DataError if the file cannot be written
void write_frames_csv(const std::filesystem::path& path, const RunRecord& record);

/// @throws DataError if the file cannot be used
[[nodiscard]] std::vector<FrameRow> read_frames_csv(const std::filesystem::path& path);

}  // namespace limber
