// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/diagnose/health_summary.hpp"
#include "limber/health/calibration_watch.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

/// @file
/// What a page shows of a run: plain data that whoever navigates fills in.
namespace limber {

/// What does not change during a run.
struct ViewRun {
  std::string title;       ///< of the recording
  std::string method;      ///< that navigates
  std::size_t frames = 0;  ///< of the recording
  /// assumed; its theta is what the page counts from
  StereoCalibration calibration;
  /// tolerance and windows of the verdict
  WatchOptions watch;
};

/// What became of a point of a frame.
enum class ViewPointFate : std::uint8_t {
  kUsed,     ///< it corrected the state
  kRefused,  ///< by the gate, or because its landmark does not project
  kOther     ///< not in the map
};

/// A point of a frame.
struct ViewPoint {
  /// its pixels
  StereoObservation seen;
  /// what became of it
  ViewPointFate fate = ViewPointFate::kOther;
};

/// A point of the map.
struct ViewLandmark {
  /// as in StereoObservation
  std::int64_t track_id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();  ///< [m]
};

/// Time that one stage took for a frame.
struct ViewStage {
  /// as the page shows it
  std::string name;
  /// time spent [ms]
  double ms = 0.0;
};

/// JPEG files of the left and the right image; both empty if there are none.
using ViewImages = std::array<std::vector<std::uint8_t>, 2>;

/// A run after a frame.
struct ViewFrame {
  std::size_t number = 0;  ///< of frames done
  double t_s = 0.0;        ///< since the first frame
  /// unless it waits
  Pose T_world_body;
  std::optional<Eigen::Vector3d> v_world_body;       ///< [m/s]
  std::optional<Eigen::Matrix<double, 6, 1>> sigma;  ///< of position [m] and attitude [rad]
  std::string status;                                ///< of the update, and of the inputs before it
  /// The run has no pose yet: it takes this frame in for its start. The frame comes again with one.
  bool waiting = false;
  /// of the frame
  std::vector<ViewPoint> points;
  /// active and passive landmarks
  std::vector<ViewLandmark> map;
  /// in the order of the work
  std::vector<ViewStage> stages;
  std::optional<HealthSummary> health;  ///< nothing before the first window is over
  /// Makes the images; called at most once, on another thread, and only if a page shows the frame. A
  /// DataError of it counts as no images, and the status says why.
  std::function<ViewImages()> images;
};

}  // namespace limber
