// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "limber/state/estimate.hpp"
#include "random_geometry.hpp"

/// Small maps for tests, and a way to read them that does not depend on where things are stored.
namespace limber::testing {

/// Symmetric positive definite, every two components correlated.
Eigen::MatrixXd random_positive_definite(Generator& generator, Eigen::Index n, double sigma);

/// Another mean of the body: `change` is handed its state.
template <typename Change>
void move_body(Estimate& estimate, Change change) {
  NavigationState nav = estimate.nav();
  change(nav);
  estimate.set_nav(nav);
}

/// Of an IMU, with steps of its biases.
StateLayout with_supposed_steps();

Estimate random_estimate(Generator& generator, StateLayout layout = {MotionModel::kImu, false});

/// A landmark some metres before the camera, correlated with all that is there (P stays positive definite).
void add_random_landmark(Generator& generator, Estimate& estimate, std::int64_t track_id, int anchor);

/// A body with odometry that is known well, at the origin, and nothing else.
Estimate empty_map();

/// An inverse-depth landmark `depth` before the body's camera, which looks along z from where the body
/// stands.
void add_landmark_ahead(Estimate& estimate, std::int64_t track_id, double depth, double sigma_rho,
                        std::int64_t seen_ns);

/// `count` landmarks with ids 0, 1, ...: some Cartesian, the others on anchors of three each.
Estimate random_map(Generator& generator, int count, StateLayout layout = {MotionModel::kImu, false});

/// How the error state sees the world turn and move, which no sensor of ours can see (gravity aside): 6
/// columns.
Eigen::MatrixXd gauge(const Estimate& estimate);

/// Mean and covariance in an order of their own: body, theta, then by track id each landmark and its anchor.
struct Snapshot {
  std::vector<std::int64_t> track_ids;
  Eigen::VectorXd mean;
  Eigen::MatrixXd P;

  bool operator==(const Snapshot& other) const;
};

/// The covariance of what is awake, without the clone that an epoch begins with (then the body twice).
Eigen::MatrixXd awake_covariance(const Estimate& estimate);

/// @param without  landmarks to leave out
Snapshot snapshot(const Estimate& estimate, const std::vector<std::int64_t>& without = {});

}  // namespace limber::testing
