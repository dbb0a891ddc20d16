// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "limber/study/curve.hpp"
#include "limber/study/run_figures.hpp"
#include "limber/study/study_plan.hpp"

/// The unit of work of a study: one run of one case, all methods on the same recording.
namespace limber {

/// A filter whose position is that far off has diverged [m].
inline constexpr double kAbsurdPositionError = 1000.0;

/// Values of one quantity, one per stereo frame; NaN where there is none.
struct RunSeries {
  /// of what
  CurveQuantity quantity = CurveQuantity::kPositionSquaredError;
  /// one per stereo frame; those from a divergence on are missing
  std::vector<double> values;
};

/// One method of it: figures, series over time and, of run 0, the path.
struct MethodResult {
  /// figures of merit
  StudyRun run;
  std::vector<RunSeries> series;           ///< one per quantity that is defined for the method
  std::vector<Eigen::Vector3d> positions;  ///< p_world_body after each frame [m]; run 0 only
};

/// All methods of one run of a case.
struct ItemResult {
  std::size_t study_case = 0;  ///< index in the plan
  /// its number, from 0
  std::uint64_t run = 0;
  std::vector<MethodResult> methods;  ///< in the order of the case
};

/// Thrown by compute_item when it is told to stop.
struct ItemCancelled {};

/// @brief Simulates run `run` of a case and runs every method on it. Pure but for the timings: the same
/// arguments give the same bits on the same kind of processor. A method that throws, whose state or pose
/// covariance breaks, or whose error is absurd has diverged: its series end before that frame and its figures
/// are empty.
/// @param frame_done  called after every frame of every method; returns false to stop. May be empty.
/// @throws ItemCancelled; what `simulate` throws
[[nodiscard]] ItemResult compute_item(const StudyPlan& plan, std::size_t study_case, std::uint64_t run,
                                      const std::function<bool()>& frame_done = {});

/// A result as bytes, to send to another process of the same build, and back.
[[nodiscard]] std::string to_bytes(const ItemResult& result);
/// @throws std::invalid_argument if the bytes are no result
[[nodiscard]] ItemResult item_from_bytes(std::string_view bytes);

}  // namespace limber
