// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/state/estimate.hpp"
#include "limber/state/initial_sigma.hpp"
#include "limber/state/state.hpp"

namespace limber {

/// Where to start.
struct InitialState {
  /// mean; its time may be 0: that of the first sample or frame
  NavigationState nav;
  Eigen::MatrixXd body_covariance;  ///< StateLayout::body_size() wide
  /// A first map, if there is one: n inverse-depth points, anchored in the left camera at `nav`.
  std::vector<Landmark> landmarks = {};
  Eigen::MatrixXd landmarks_covariance = {};  ///< 3n×3n
  Eigen::MatrixXd landmarks_body = {};        ///< with the body, 3n×body_size()
  /// By how much body and points are off for each parameter beyond theta (parameters.hpp) that is off by one,
  /// (body_size + 3n) x kMoreParameters; empty where none is estimated. What the covariances above say is
  /// beside that.
  Eigen::MatrixXd by_parameters = {};
  /// How much later than taken an IMU's samples are stamped [ns]: those that are given are corrected by it.
  std::int64_t clock_offset_ns = 0;
  /// How well the clock of an IMU is known (standard deviation) [s], and by how much body and points are off
  /// for each second that its samples are stamped later than they are taken for, body_size + 3n. Known
  /// exactly where empty. What the covariances above say is beside that.
  double clock_sigma = 0.0;
  /// see clock_sigma
  Eigen::VectorXd by_clock = {};
  /// False where nothing had told the scale, with an IMU: the map has the rig's, and what is known of it is
  /// what was known without the rig.
  bool scale_told = true;
  /// How much noisier the IMU is than stated, by what the start saw of it.
  ImuNoiseFactors imu_noise = {};
  /// Where the above trusts the rig after all: the same start without that trust. The parallel filter of
  /// `adaptive` begins there, and it goes back there once the rig is proven wrong. Else none.
  std::shared_ptr<const InitialState> distrusting = nullptr;
};

/// An initial state with uncorrelated, isotropic uncertainty.
[[nodiscard]] InitialState make_initial_state(const NavigationState& nav, MotionModel motion,
                                              const InitialSigma& sigma);

/// @brief Puts the first map of a start into an estimate that stands where the start does; their anchor is a
/// clone of the body.
/// @param T_body_cam0  of the left camera
void place_first_map(Estimate& estimate, const InitialState& initial, const Pose& T_body_cam0);

/// @brief Makes body and first map as unsure as the parameters beyond theta that they rest on, and correlates
/// them: after place_first_map, before anything else. Nothing where `by_parameters` is empty.
void correlate_with_parameters(Estimate& estimate, const InitialState& initial);

/// @brief The same with the clock of an IMU, which is as open as `clock_sigma` from then on. Whether or not
/// the first map was placed. For layouts that have its step.
void correlate_with_clock(Estimate& estimate, const InitialState& initial);

}  // namespace limber
