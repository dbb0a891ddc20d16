// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "known_state.hpp"
#include "least_squares.hpp"
#include "limber/predict/input_buffer.hpp"
#include "reduced_system.hpp"
#include "tracks.hpp"

namespace limber::detail {

/// @throws std::invalid_argument if shapes disagree
void check(const SmootherInput& input, const SmootherOptions& options);

/// One solution after another: states, tracks, and what lies between frames, kept from round to round.
class Smoothing {
 public:
  /// @param progress  told of each iteration; may be empty
  /// @param known     what is known of the first frame, in the place of the input's prior; may be null
  Smoothing(const SmootherInput& input, const StereoCalibration& calibration, const SmootherOptions& options,
            const std::function<void(int)>& progress = {}, const KnownState* known = nullptr);

  /// Half the squared residuals under Cauchy's loss, before anything is solved.
  [[nodiscard]] double cost();
  /// Solves, and leaves out the pixels that do not fit.
  /// @throws UnsolvableError
  void solve();
  /// Of the solution.
  [[nodiscard]] SmootherResult result();
  /// What the solution says of the last frame, and its covariances into `frame`, the last of result().
  [[nodiscard]] KnownState newest(SmoothedFrame& frame);

 private:
  void place_states();
  void place_rigs();
  void place_landmarks(const MountedRig& rig);
  void cut_inputs();
  void sum_up_inputs();
  void solve_under(RobustLoss loss, int max_iterations);
  bool refuse_pixels();
  void count_pixels(SmootherResult& out);
  void add_covariances(SmootherResult& out);
  void add_covariances(const Marginals& marginals, std::size_t k, SmoothedFrame& frame) const;

  const SmootherInput& input_;
  const StereoCalibration& calibration_;
  const SmootherOptions& options_;
  std::function<void(int)> progress_;
  const KnownState* known_;
  Unknowns unknowns_;
  std::vector<Track> tracks_;
  std::vector<std::vector<InputStep>> steps_;
  double sample_interval_s_ = 0.0;
  std::vector<MotionBetween> between_;
  std::unique_ptr<LeastSquares> problem_;
  int iterations_ = 0;
  bool converged_ = false;
};

}  // namespace limber::detail
