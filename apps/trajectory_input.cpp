// SPDX-License-Identifier: MIT
#include "trajectory_input.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

#include "limber/bags/bag_contents.hpp"
#include "limber/bags/bag_file.hpp"
#include "limber/bags/bag_topics.hpp"
#include "limber/bags/write_results.hpp"
#include "limber/core/errors.hpp"
#include "limber/core/nearest_word.hpp"
#include "limber/core/time.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/datasets/recording_place.hpp"
#include "limber/datasets/trajectory_files.hpp"

namespace limber::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRunResult = "trajectory.csv";  // in the folder of a run

// limber's own file, with covariance.
TrajectoryInput load_rows(const fs::path& path) {
  TrajectoryInput input{path, true, {}, {}, ""};
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
  return {path, trajectory.has_time, std::move(trajectory.poses), {}, ""};
}

TrajectoryInput load_groundtruth(const fs::path& folder) {
  TrajectoryInput input{folder, true, poses_of(limber::read_recording(folder).truth.motion.states), {}, ""};
  if (input.poses.empty()) {
    throw DataError(folder.string(), 0,
                    "a trajectory: trajectory.csv of a run, or a recording with ground truth",
                    "a recording without ground truth");
  }
  return input;
}

/// The truth of a recording; of an EuRoC folder without reading all the rest.
TrajectoryInput load_recorded(const fs::path& folder) {
  const fs::path groundtruth = fs::path("state_groundtruth_estimate0") / "data.csv";
  for (const fs::path& file : {folder / "mav0" / groundtruth, folder / groundtruth}) {
    if (fs::exists(file)) {
      return load_file(file);
    }
  }
  return load_groundtruth(folder);
}

/// Results that lie beside a recording are not its truth.
TrajectoryInput load_unless_bag(const fs::path& path, const std::string& topic) {
  return topic.empty() && holds_recording(path) ? load_recorded(path) : load_trajectory(path, topic);
}

/// What a bag without a topic to take has in its place.
std::string other_positions(const BagContents& contents) {
  for (const BagStream& stream : contents.streams) {
    const std::string& type = stream.topic.type;
    if (type == "geometry_msgs/PointStamped") {
      return fmt::format("; {} has positions alone, without attitude", stream.topic.name);
    }
    if (type == "tf2_msgs/TFMessage" || type == "tf/tfMessage") {
      return fmt::format("; a tree of frames ({}) is not read", stream.topic.name);
    }
  }
  return "";
}

const BagStream& stream_of_poses(const fs::path& path, const BagContents& contents,
                                 const std::string& topic) {
  std::vector<const BagStream*> found;
  std::vector<std::string> names;
  for (const BagStream& stream : contents.streams) {
    if (!stream.poses.empty()) {
      found.push_back(&stream);
      names.push_back(stream.topic.name);
    }
  }
  const bool of_run = topic.empty() && std::find(names.begin(), names.end(), kOdometryOfRun) != names.end();
  const auto named = std::find(names.begin(), names.end(), of_run ? std::string(kOdometryOfRun) : topic);
  if (named != names.end()) {
    return *found[static_cast<std::size_t>(named - names.begin())];
  }
  const std::string known =
      names.empty() ? "none" + other_positions(contents) : fmt::format("{}", fmt::join(names, ", "));
  if (!topic.empty()) {
    throw DataError(path.string(), 0, "poses on " + topic + did_you_mean(topic, names),
                    "poses (PoseStamped, TransformStamped, Odometry) on " + known);
  }
  if (found.size() != 1) {
    throw DataError(path.string(), 0, "one topic of poses, or the name of it",
                    "poses (PoseStamped, TransformStamped, Odometry) on " + known);
  }
  return *found.front();
}

/// In the order of their stamps, each stamp once.
TrajectoryInput load_poses(const fs::path& path, const BagContents& contents, const std::string& topic) {
  const BagStream& stream = stream_of_poses(path, contents, topic);
  TrajectoryInput input{path, true, stream.poses, {}, stream.topic.name};
  const auto earlier = [](const StampedPose& a, const StampedPose& b) { return a.t_ns < b.t_ns; };
  std::stable_sort(input.poses.begin(), input.poses.end(), earlier);
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.t_ns == b.t_ns; };
  input.poses.erase(std::unique(input.poses.begin(), input.poses.end(), same), input.poses.end());
  return input;
}

std::string seconds_covered(const TrajectoryInput& input) {
  return fmt::format("{:.3f} s to {:.3f} s", to_seconds(input.poses.front().t_ns),
                     to_seconds(input.poses.back().t_ns));
}

}  // namespace

TrajectoryInput load_trajectory(const fs::path& path, const std::string& topic) {
  if (is_bag(path)) {
    return load_poses(path, scan_bag(*open_bag(path)), topic);
  }
  if (!topic.empty()) {
    throw DataError(path.string(), 0, "a bag, for the topic " + topic, "none");
  }
  if (fs::is_directory(path)) {
    return fs::exists(path / kRunResult) ? load_file(path / kRunResult) : load_recorded(path);
  }
  return load_file(path);
}

TrajectoryInput load_truth(const fs::path& path, const std::string& topic) {
  if (!is_bag(path)) {
    return load_unless_bag(path, topic);
  }
  const BagContents contents = scan_bag(*open_bag(path));
  return load_poses(path, contents, topic.empty() ? propose_topics(contents).topics.truth : topic);
}

TrajectoryInput load_poses_to_convert(const fs::path& path, const std::string& topic) {
  if (!is_bag(path)) {
    return load_unless_bag(path, topic);
  }
  const BagContents contents = scan_bag(*open_bag(path));
  const bool of_a_run =
      std::any_of(contents.streams.begin(), contents.streams.end(),
                  [](const BagStream& stream) { return stream.topic.name == kOdometryOfRun; });
  return load_poses(path, contents,
                    topic.empty() && !of_a_run ? propose_topics(contents).topics.truth : topic);
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
