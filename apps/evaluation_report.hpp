// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "limber/evaluate/consistency.hpp"
#include "limber/evaluate/error_over_distance.hpp"
#include "limber/evaluate/evaluation.hpp"
#include "limber/evaluate/statistics.hpp"
#include "limber/evaluate/world_tilt.hpp"
#include "ordered_json.hpp"
#include "trajectory_input.hpp"

/// An evaluation as JSON and as text. What is not known is null, or a dash.
namespace limber::app {

/// Consistency of an estimate as it is, aligned at its first pose by position and yaw, and the same after the
/// tilt between the worlds is taken out, where they are askew.
struct ConsistencyReport {
  Consistency none;
  Consistency first_pose;
  std::optional<Consistency> upright;
};

/// Everything that `limber evaluate` says.
struct EvaluationReport {
  std::string estimate, truth;  ///< paths
  std::size_t estimated_poses = 0;
  bool matched_by_time = true;
  double max_time_difference = 0.0;  ///< [s]
  RelativeErrorSettings settings;
  TrajectoryEvaluation evaluation;
  std::optional<WorldTilt> tilt;         ///< between the verticals of both worlds
  std::optional<AlignedErrors> upright;  ///< errors with that tilt taken out, where the worlds are askew
  std::vector<ErrorOverDistance> over_distance;
  std::optional<ConsistencyReport> consistency;  ///< nothing without covariances
};

/// @brief Matches the poses and compares them in every way. NEES needs a covariance with every pose that
/// enters.
/// @throws std::runtime_error if nothing matches
[[nodiscard]] EvaluationReport evaluate(const TrajectoryInput& estimate, const TrajectoryInput& truth,
                                        double max_time_difference, const RelativeErrorSettings& settings);

/// {rmse, mean, median, std, min, max, sse, count}
[[nodiscard]] Json to_json(const Statistics& statistics);

/// {none, se3, sim3, scale}: rmse [m] after each alignment, and the scale of the last; the ate_m of
/// summary.json.
[[nodiscard]] Json ate_json(const TrajectoryEvaluation& evaluation);

/// {pose, position, attitude: average NEES per d.o.f., frames, frames_refused, share_within_95}
[[nodiscard]] Json to_json(const Consistency& consistency);

[[nodiscard]] Json to_json(const EvaluationReport& report);

/// Aligned tables, to be read in a terminal at least 110 characters wide.
[[nodiscard]] std::string to_text(const EvaluationReport& report);

}  // namespace limber::app
