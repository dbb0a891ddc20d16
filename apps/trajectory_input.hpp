// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "limber/core/pose.hpp"
#include "limber/evaluate/association.hpp"
#include "limber/evaluate/consistency.hpp"

namespace limber::app {

/// A trajectory that the user named, whatever it came from.
struct TrajectoryInput {
  std::filesystem::path path;               ///< of the file, or of the folder of a recording
  bool has_time = true;                     ///< false: t_ns counts poses
  std::vector<StampedPose> poses;           ///< at least one
  std::vector<PoseCovariance> covariances;  ///< as many as poses, or empty. A row without one holds NaN.
  std::string topic;                        ///< of a bag that the poses come from, else empty
};

/// @brief Reads a trajectory file of any format, the trajectory.csv of a run's folder, a recording's ground
/// truth, or poses in a bag.
/// @param topic  of a bag: PoseStamped, PoseWithCovarianceStamped, TransformStamped or Odometry; empty: that
/// of
///               a run of limber's, else the only one with poses. Of what is no bag there is none
/// @throws DataError if there is none, or it cannot be used
[[nodiscard]] TrajectoryInput load_trajectory(const std::filesystem::path& path,
                                              const std::string& topic = "");

/// The same of what is to be the truth: of a folder that holds a recording its own; of a bag, without a
/// topic, first the one that is named like a truth.
[[nodiscard]] TrajectoryInput load_truth(const std::filesystem::path& path, const std::string& topic = "");

/// The same of what is to be written in another format: of a bag, without a topic, the poses of limber's own
/// run if it holds one, else as load_truth.
[[nodiscard]] TrajectoryInput load_poses_to_convert(const std::filesystem::path& path,
                                                    const std::string& topic = "");

/// How poses of two trajectories found each other.
struct Match {
  std::vector<MatchedPose> poses;  ///< at least one
  bool by_time = true;
};

/// @brief Matches by time where both inputs have times, else by index.
/// @throws std::runtime_error if nothing matches; says what both cover and what to try
[[nodiscard]] Match match(const TrajectoryInput& estimate, const TrajectoryInput& truth,
                          double max_time_difference);

}  // namespace limber::app
