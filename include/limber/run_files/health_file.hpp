// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include "limber/navigate/frame_report.hpp"

namespace limber {

/// A row of health.csv: what was known when a window ended.
struct HealthRow {
  std::int64_t t_ns = 0;                                      ///< last frame of the window
  std::int64_t window_from_ns = 0;                            ///< its first
  std::int64_t since_ns = 0;                                  ///< first frame since the last change
  bool changed = false;                                       ///< the change was found in this window
  HealthVerdict verdict = HealthVerdict::kCannotTell;         ///< since then
  HealthVerdict window_verdict = HealthVerdict::kCannotTell;  ///< of this window alone
  SizeInterval epipolar_px, depth;                            ///< since then; depth as a share
  /// measured minus true, as a share
  double depth_signed = 0.0;
  RigParameters delta, sigma;                ///< since then, true minus assumed theta [rad, m]
  RigParameters window_delta, window_sigma;  ///< of this window alone [rad, m]
  std::array<HealthVerdict, 6> axes{};       ///< since then
};

/// What health.csv says of the window that ends at a frame.
[[nodiscard]] HealthRow health_row(const CalibrationReport& report);

/// Columns: docs/formats-health.md. One row for each window.
void write_health_csv(const std::filesystem::path& path, std::span<const FrameReport> frames);

/// @throws DataError with file, line and what was expected
[[nodiscard]] std::vector<HealthRow> read_health_csv(const std::filesystem::path& path);

}  // namespace limber
