// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "limber/datasets/recording.hpp"
#include "limber/evaluate/alignment.hpp"
#include "limber/run/run_recording.hpp"
#include "limber/study/study_item.hpp"

namespace limber::detail {

/// Mean squared error of the points of a map that have a place.
struct MapError {
  std::size_t points = 0;
  double mean_squared = 0.0;  ///< [m^2]; meaningless without points
};

/// @brief Watches one run of one method frame by frame against the truth, and keeps the series that curves
/// are made of.
class RunObserver {
 public:
  /// @param recording with truth; must outlive this
  RunObserver(const Recording& recording, const Scenario& scenario, StartMode start);

  /// Takes down what the filter says after a frame, or the start of a frame that it has used up. @throws
  /// DivergenceError: nothing of this frame is kept then
  void observe(const ObservedFrame& frame);

  /// A divergence at the frame that was being processed.
  [[nodiscard]] Divergence divergence(const std::string& reason) const;
  /// After the last frame.
  [[nodiscard]] const MapError& map_error() const { return map_error_; }

  [[nodiscard]] std::vector<RunSeries> take_series();
  [[nodiscard]] std::vector<Eigen::Vector3d> take_positions() { return std::move(positions_); }

 private:
  [[nodiscard]] std::size_t slot_of(std::int64_t t_ns) const;
  void set(CurveQuantity quantity, double value);
  void align(const TrajectoryRow& first);
  void observe_pose(const TrajectoryRow& row);
  void observe_theta(const Navigator& navigator);
  void observe_map(const Navigator& navigator);

  const Recording& recording_;
  const Scenario& scenario_;
  StartMode start_;
  std::optional<Alignment> alignment_;  // of the estimate with the truth, once there is a first pose
  std::size_t slots_;                   // frames if none is lost
  std::map<CurveQuantity, std::vector<double>> series_;
  std::map<CurveQuantity, double> frame_;  // values of the frame at hand
  std::vector<Eigen::Vector3d> positions_;
  MapError map_error_;
  std::size_t observed_ = 0;
};

}  // namespace limber::detail
