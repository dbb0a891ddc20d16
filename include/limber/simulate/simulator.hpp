// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "limber/datasets/recording.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/simulate/scenario.hpp"
#include "limber/simulate/spline_trajectory.hpp"

/// Recordings made from scenarios. Every function is pure: the same scenario, seed and run give the same
/// bits. Each kind of draw has its own stream (random.hpp), so that switching one thing off leaves the other
/// draws as they are: the same scenario with another decalibration has the same trajectory, world, IMU and
/// pixel noise.
namespace limber {

/// Times of a sensor of `rate` [Hz], from 0 to `duration` [s], both included: [ns].
[[nodiscard]] std::vector<std::int64_t> sample_times(double rate, double duration);

/// The rig of a scenario as its recordings say it: what estimators may assume.
[[nodiscard]] StereoCalibration nominal_calibration(const Scenario& scenario);

/// @brief What the sensors deliver in this scenario, with the truth beside it.
/// Times start at 0. IMU and odometry samples are instantaneous values; ground truth has the IMU's times;
/// truth.rig has those of the frames and of every jump. `calibration` is the nominal rig. Landmarks
/// that no frame shows are left out, and those that move; their indices are the track ids.
/// @throws std::invalid_argument if check_scenario does
/// @throws DataError if the file of a FileTrajectory cannot be used, or is shorter than the scenario
[[nodiscard]] Recording simulate(const Scenario& scenario, std::uint64_t seed, std::uint64_t run = 0);

/// The trajectory that `simulate` follows. Throws like it.
[[nodiscard]] SplineTrajectory make_trajectory(const Scenario& scenario, std::uint64_t seed,
                                               std::uint64_t run = 0);

/// The points that `simulate` scatters around `trajectory`, p_world_landmark [m]. Throws like it.
[[nodiscard]] std::vector<Eigen::Vector3d> make_world(const Scenario& scenario,
                                                      const SplineTrajectory& trajectory, std::uint64_t seed,
                                                      std::uint64_t run = 0);

}  // namespace limber
