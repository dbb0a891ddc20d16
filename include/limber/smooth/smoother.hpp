// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "limber/predict/motion_between.hpp"
#include "limber/sensors/image_cell.hpp"
#include "limber/sensors/parameters.hpp"
#include "limber/sensors/samples.hpp"
#include "limber/state/initial_state.hpp"
#include "limber/state/state.hpp"

/// @file
/// Navigation as one least-squares problem: all states, landmarks and the rig of a window or of a whole
/// recording at once, linearised where they end up. docs/derivations/smoother.md.
namespace limber {

/// What the rig theta does over time.
enum class RigModel : std::uint8_t {
  kTrusted,    ///< it is what the calibration says
  kConstant,   ///< unknown, one and the same in all frames
  kPiecewise,  ///< unknown, constant for `piece_s` at a time, one piece independent of the next
  kWalk,       ///< a random walk from frame to frame
  kFree        ///< unknown and new in every frame: the form of the constraint
};

/// How large residuals are weighed down.
enum class RobustLoss : std::uint8_t { kNone, kHuber, kCauchy };

/// What a problem takes for given, leaves free, and how long it is worked on.
struct SmootherOptions {
  /// what drives the prediction
  MotionModel motion = MotionModel::kImu;
  /// of the inputs
  MotionNoise noise;
  /// u0, v0, u1, v1: white, per coordinate [px]
  PixelNoise sigma_px = PixelNoise::Constant(0.5);
  double gravity = 9.81;  ///< [m/s^2]

  /// what theta does over time
  RigModel rig = RigModel::kFree;
  double piece_s = 5.0;  ///< kPiecewise [s]
  /// The baseline is as long as the calibration says: for recordings in which nothing else fixes the scale.
  bool trust_length = false;
  /// Standard deviation of theta before anything is seen (kFree: it is taken for unknown). Zero: 1 deg, 50 %
  /// of the baseline.
  RigParameters rig_sigma = RigParameters::Zero();
  RigParameters rig_walk = RigParameters::Constant(1e-4);  ///< kWalk: variance per second [rad²/s, m²/s]
  /// Parameters beyond theta to estimate as constants: standard deviations before anything is seen; zero: no.
  ParameterVector estimated = ParameterVector::Zero();

  RobustLoss loss = RobustLoss::kHuber;  ///< of each pixel; with kNone no pixel is refused either
  double gate_probability = 0.9999;      ///< chance that a good pixel is kept
  double forget_after_s = 3.0;           ///< a track that was away for longer is another point
  /// of each solution; there are up to five, under one loss after the other
  int max_iterations = 50;
  /// whether covariances are wanted; else they are zero
  bool covariance = true;
  /// of the solver
  int threads = 1;
};

/// What is to be smoothed.
struct SmootherInput {
  std::span<const StereoFrame> frames;       ///< strictly increasing time; at least one
  std::span<const ImuSample> imu;            ///< kImu: covers the frames
  std::span<const OdometrySample> odometry;  ///< kOdometry: covers the frames
  std::span<const NavigationState> start;    ///< one per frame: where the iteration begins
  InitialState prior;                        ///< what is known of the first state beforehand
};

/// What the smoother says of one frame.
struct SmoothedFrame {
  /// of the body
  NavigationState nav;
  Eigen::Matrix<double, 6, 6> pose_covariance;  ///< position in the world, attitude local
  /// of what the motion model adds, in the order of StateLayout: velocity in the world [m/s], then the biases
  /// of gyro [rad/s] and accelerometer [m/s²], or the rate [rad/s]; empty with odometry or without
  /// covariances
  Eigen::MatrixXd motion_covariance;
  RigParameters theta = RigParameters::Zero();      ///< the rig in this frame
  Eigen::Matrix<double, 6, 6> theta_covariance;     ///< zero where it is trusted
  ParameterVector error = ParameterVector::Zero();  ///< true minus given, beyond theta
  /// standard deviation of `error`; zero where it is not estimated
  ParameterVector error_sigma = ParameterVector::Zero();
  std::size_t observed = 0, used = 0;  ///< points
  double squared_residuals = 0.0;      ///< of the whitened pixels used [-]
  std::size_t rows = 0;                ///< of them
};

/// A pixel that was left out.
struct RefusedPixel {
  /// index into SmootherInput::frames
  std::size_t frame = 0;
  /// of the point
  std::int64_t track_id = 0;
  /// 0: left, 1: right
  int camera = 0;
  double distance = 0.0;  ///< squared, whitened [-]
};

/// The solution with its marginal covariances.
struct SmootherResult {
  /// one per frame of the input
  std::vector<SmoothedFrame> frames;
  std::map<std::int64_t, Eigen::Vector3d> landmarks;  ///< p_world_landmark [m]
  /// Of a constant rig, by image_cell of a point's first left pixel.
  std::map<int, CellScore> theta_scores;
  /// pixels that were left out
  std::vector<RefusedPixel> refused;
  double squared_residuals = 0.0;  ///< of all rows, whitened [-]
  std::ptrdiff_t dof = 0;          ///< rows less unknowns
  /// of all rounds together
  int iterations = 0;
  /// the last solution ended before its last iteration
  bool converged = false;
};

/// Half the squared residuals under Cauchy's loss with the states of the start and landmarks triangulated
/// from them: how well a first guess explains what was measured. Throws as smooth does.
[[nodiscard]] double cost_of_start(const SmootherInput& input, const StereoCalibration& calibration,
                                   const SmootherOptions& options);

/// @brief Solves for everything at once.
/// @param progress  told of each iteration; what it throws ends the work and passes through; may be empty
/// @throws std::invalid_argument if shapes disagree or the input does not cover the frames
/// @throws UnsolvableError       if the problem cannot be solved: the message says why
[[nodiscard]] SmootherResult smooth(const SmootherInput& input, const StereoCalibration& calibration,
                                    const SmootherOptions& options,
                                    const std::function<void(int)>& progress = {});

}  // namespace limber
