// SPDX-License-Identifier: MIT
#include "trajectory_input.hpp"

#include <fmt/format.h>

#include <limits>
#include <stdexcept>

#include "limber/bags/bag_file.hpp"
#include "limber/core/errors.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/trajectory_files.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

// limber's own file, with covariance.
TrajectoryInput load_rows(const fs::path& path) {
  TrajectoryInput input{path, true, {}, {}};
  bool any = false;
  for (const TrajectoryRow& row : read_trajectory_csv(path)) {
    input.poses.push_back({row.t_ns, row.T_world_body});
    input.covariances.push_back(
        row.covariance.value_or(PoseCovariance::Constant(std::numeric_limits<double>::quiet_NaN())));
    any = any || row.covariance.has_value();
  }
  if (!any) {
    input.covariances.clear();
  }
  return input;
}

TrajectoryInput load_file(const fs::path& path) {
  Trajectory trajectory = read_trajectory(path);
  if (trajectory.format == TrajectoryFormat::kLimber) {
    return load_rows(path);
  }
  return {path, trajectory.has_time, std::move(trajectory.poses), {}};
}

TrajectoryInput load_groundtruth(const fs::path& folder) {
  TrajectoryInput input{folder, true, {}, {}};
  for (const GroundTruthState& state : limber::read_recording(folder).groundtruth) {
    input.poses.push_back({state.t_ns, {state.R_world_body, state.p_world_body}});
  }
  if (input.poses.empty()) {
    throw DataError(folder.string(), 0,
                    "a trajectory: trajectory.csv of a run, or a recording with ground truth",
                    "a recording without ground truth");
  }
  return input;
}

std::string seconds_covered(const TrajectoryInput& input) {
  return fmt::format("{:.3f} s to {:.3f} s", static_cast<double>(input.poses.front().t_ns) * 1e-9,
                     static_cast<double>(input.poses.back().t_ns) * 1e-9);
}

}  // namespace

TrajectoryInput load_trajectory(const fs::path& path) {
  if (is_bag(path)) {
    throw DataError(path.string(), 0, "a trajectory, or the folder of a recording",
                    "a bag: limber run compares with the truth in it, limber convert makes a folder of it");
  }
  if (!fs::is_directory(path)) {
    return load_file(path);
  }
  // Within a folder: a run's result, the ground truth file of an EuRoC folder (without reading all the rest).
  const fs::path groundtruth = fs::path("state_groundtruth_estimate0") / "data.csv";
  for (const fs::path& file : {path / "trajectory.csv", path / "mav0" / groundtruth, path / groundtruth}) {
    if (fs::exists(file)) {
      return load_file(file);
    }
  }
  return load_groundtruth(path);
}

Match match(const TrajectoryInput& estimate, const TrajectoryInput& truth, double max_time_difference) {
  if (!estimate.has_time || !truth.has_time) {
    if (estimate.poses.size() != truth.poses.size()) {
      throw std::runtime_error(
          fmt::format("{} has no times, so poses are matched line by line, but {} has {} poses and {} has {}",
                      (estimate.has_time ? truth : estimate).path.string(), estimate.path.string(),
                      estimate.poses.size(), truth.path.string(), truth.poses.size()));
    }
    return {match_by_index(estimate.poses, truth.poses), false};
  }
  Match match{match_by_time(estimate.poses, truth.poses, max_time_difference), true};
  if (match.poses.empty()) {
    throw std::runtime_error(fmt::format(
        "no pose has ground truth within {} s: {} covers {}, {} covers {}; if the clocks differ by less, try "
        "--max-time-difference",
        max_time_difference, estimate.path.string(), seconds_covered(estimate), truth.path.string(),
        seconds_covered(truth)));
  }
  return match;
}

}  // namespace limber::app
