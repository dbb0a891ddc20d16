// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "limber/run/run_recording.hpp"
#include "limber/smooth/smoother.hpp"

/// @file
/// A recording through the smoother. There only if limber was built with Ceres (LIMBER_BUILD_SMOOTH).
namespace limber {

/// What a user chooses for smoothing; noise, motion model and the like follow from the recording as for a
/// run.
struct SmoothOptions {
  RunOptions run;  ///< what is assumed, and how the filters that give the first guess start
  /// what theta does over time
  RigModel rig = RigModel::kFree;
  double piece_s = 5.0;  ///< kPiecewise [s]
  /// Each state from the frames up to it alone, those of so many seconds solved anew with it [s]; nothing:
  /// from all frames. What a start from the sensors has used up is as its last frame sees it.
  std::optional<double> causal_window_s;
  /// of each pixel
  RobustLoss loss = RobustLoss::kHuber;
  /// The filter whose trajectory is the first guess; nothing: ekf and lcekf, the one that explains the pixels
  /// better.
  std::optional<Method> guess;
  /// of the solver
  int threads = 1;
};

/// What to do with theta, as on the command line: trusted, constant, piecewise:SECONDS, walk or free.
struct RigModelText {
  /// what theta does over time
  RigModel rig = RigModel::kFree;
  /// kPiecewise: length of a piece [s]
  double piece_s = 5.0;
};
/// @throws std::invalid_argument for anything else
[[nodiscard]] RigModelText rig_model_from_string(const std::string& text);
/// The word that rig_model_from_string reads back.
[[nodiscard]] std::string to_string(RigModel rig);
/// What a run by it is called: smooth-free, smooth-constant-causal, ...
[[nodiscard]] std::string to_string(const SmoothOptions& options);

/// @brief Solves for the whole recording at once, as run_recording leaves it behind: a row for each frame,
/// each with what all frames say of it, or those until then.
/// frames: nis and dof count the pixels used in a frame, dof less its share of the unknowns.
/// @param progress  told of work in per cent; may be empty
/// @throws as run_recording; std::runtime_error also if the solution is not found
[[nodiscard]] RunRecord smooth_recording(const Recording& recording, const SmoothOptions& options,
                                         const FrameSource& frames,
                                         const std::function<void(std::size_t)>& progress = {});

}  // namespace limber
