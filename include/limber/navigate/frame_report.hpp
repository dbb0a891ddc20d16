// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "limber/health/health_monitor.hpp"
#include "limber/sensors/parameters.hpp"
#include "limber/stack/stack_frame.hpp"
#include "limber/update/update.hpp"

namespace limber {

/// What became of one frame.
struct FrameReport {
  std::int64_t t_ns = 0;
  UpdateStatus status = UpdateStatus::kEmpty;
  double nis = 0.0;       ///< of the projected rows [-]
  Eigen::Index dof = 0;   ///< of nis
  Eigen::Index rank = 0;  ///< constrained directions that this frame's geometry can see
  std::size_t observed = 0;
  std::size_t used = 0;
  std::size_t initialized = 0;  ///< new in the map
  std::size_t removed = 0;
  bool gate_overruled = false;  ///< the gate would have refused most points, so it refused none
  std::vector<Refusal> refused;
  std::optional<HealthReport> health;  ///< if watched
  /// What the frame says against the rig that the filter takes for true (ekf-full, adaptive: its estimate).
  std::optional<HealthInput> evidence;
};

/// What a filter has learned of the calibration that it was given.
struct CalibrationEstimate {
  ParameterSet parameters;                          ///< those it estimates; the others are zero below
  ParameterVector error = ParameterVector::Zero();  ///< true minus given
  ParameterVector sigma = ParameterVector::Zero();  ///< standard deviation of that
};

}  // namespace limber
