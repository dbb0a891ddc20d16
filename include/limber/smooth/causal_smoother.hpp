// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>

#include "limber/smooth/smoother.hpp"

/// @file
/// The smoother as it would have answered at each frame: a moving horizon. docs/derivations/smoother.md.
namespace limber {

/// How far back each answer looks.
struct Horizon {
  /// The first frame that is answered by what came until then; those before it are as this one sees them.
  std::size_t first = 0;
  /// Frames so long before the newest are solved anew with it; what came before them is known as it was
  /// said of the oldest of them [s]
  double window_s = 2.0;
};

/// @brief One problem after another, one a frame. Row k of the result is the newest state of the problem over
/// frames [b, k], and depends on no later frame. Where b is the first frame, the problem is that of smooth().
/// Otherwise it begins with the marginal of state b (with theta, where that lasts, and the other parameters),
/// as the problem that ended with b had it; the pixels of b are in that already. Points that were seen before
/// b begin anew: nothing is counted twice, and what they tied together is forgotten.
/// @param progress  told how many frames are done; what it throws ends the work; may be empty
/// @return as smooth(): `refused` pixels as the problem saw them in which their frame was the newest;
///   squared_residuals, dof and iterations of all problems together; no theta_scores
/// @throws as smooth()
[[nodiscard]] SmootherResult smooth_causally(const SmootherInput& input, const StereoCalibration& calibration,
                                             const SmootherOptions& options, const Horizon& horizon,
                                             const std::function<void(std::size_t)>& progress = {});

}  // namespace limber
