// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/evaluation_callback.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <memory>
#include <span>
#include <vector>

#include "blocks.hpp"
#include "known_state.hpp"
#include "limber/smooth/smoother.hpp"
#include "tracks.hpp"

/// The problem that Ceres is given.
namespace limber::detail {

/// All unknowns except the landmarks, which their tracks hold.
struct Unknowns {
  std::vector<PoseBlock> pose;        ///< one per frame
  std::vector<MotionBlock> motion;    ///< one per frame; unused for odometry
  std::vector<RigParameters> theta;   ///< one per piece; the calibration's where it is trusted
  std::vector<std::size_t> theta_of;  ///< piece of each frame
  Eigen::Matrix<double, kMoreParameters, 1> more = Eigen::Matrix<double, kMoreParameters, 1>::Zero();
};

/// The cameras as theta and the other parameters have them at present, one rig per piece.
class Rigs : public ceres::EvaluationCallback {
 public:
  Rigs(const StereoCalibration& given, const Unknowns& unknowns, bool with_parameters);
  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;
  [[nodiscard]] const MountedRig& of_piece(std::size_t piece) const { return rigs_[piece]; }

 private:
  const StereoCalibration& given_;
  const Unknowns& unknowns_;
  bool with_parameters_;
  std::vector<MountedRig> rigs_;
};

/// Columns of the problem, in the order in which they are eliminated.
struct Columns {
  std::vector<double*> landmarks;  ///< three wide, independent of each other
  std::vector<int> cells;          ///< of each landmark: part of the left image that it was first seen in
  std::vector<double*> chain;      ///< velocities, biases: each coupled with its neighbours alone
  std::vector<double*> kept;       ///< poses, the last motion, theta, other parameters
  const double* rig = nullptr;     ///< theta, where it is one of all frames
};

/// @brief Unknowns, terms and their loss functions. Frames [0, frames), whatever has been left out.
class LeastSquares {
 public:
  /// @param between  what lies between frame k and k + 1
  /// @param known    what is known of the first frame, in the place of all priors of it; may be null
  LeastSquares(const SmootherInput& input, const StereoCalibration& calibration,
               const SmootherOptions& options, std::span<const MotionBetween> between, Unknowns& unknowns,
               std::vector<Track>& tracks, RobustLoss loss, const KnownState* known = nullptr);

  [[nodiscard]] ceres::Problem& problem() { return *problem_; }
  [[nodiscard]] const Columns& columns() const { return columns_; }
  /// Rows that only keep what nothing else determines in place: no evidence.
  [[nodiscard]] int vague_rows() const { return vague_rows_; }
  /// Squared whitened residual of each pixel, into the tracks.
  void judge_pixels();

 private:
  void add_states(std::span<const MotionBetween> between);
  void add_prior(const InitialState& prior);
  void add_known();
  void add_rigs(std::span<const StereoFrame> frames);
  void add_parameters();
  [[nodiscard]] std::vector<double*> blocks_of(std::size_t frame);
  void add_track(Track& track, const SmootherInput& input);

  const StereoCalibration& calibration_;
  const SmootherOptions& options_;
  Unknowns& unknowns_;
  std::vector<Track>& tracks_;
  const KnownState* known_;
  bool with_theta_, with_more_;
  Rigs rigs_;
  std::unique_ptr<ceres::LossFunction> loss_;
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<std::pair<ceres::ResidualBlockId, Sight*>> pixels_;
  Columns columns_;
  int vague_rows_ = 0;
};

/// Which of the parameters beyond theta are estimated, counted from the first of these.
[[nodiscard]] std::vector<Eigen::Index> free_parameters(const SmootherOptions& options);

/// Standard deviation of theta before anything is seen, as the options have it.
[[nodiscard]] RigParameters sigma_of_rig(const SmootherOptions& options, double baseline);

}  // namespace limber::detail
