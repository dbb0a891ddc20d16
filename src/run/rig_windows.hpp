// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "limber/run/recalibrate_recording.hpp"
#include "limber/smooth/smoother.hpp"
#include "limber/smooth/unsolvable_error.hpp"
#include "run/smooth_setup.hpp"

/// @file
/// Parts of a recording that the smoother solves for the rig, each for itself.
namespace limber::detail {

struct Keyframe {
  StereoFrame frame;
  NavigationState state;  ///< the first guess
};

using KeyframeWindow = std::vector<Keyframe>;  ///< consecutive

[[nodiscard]] std::vector<Keyframe> keyframes_of(const Guess& guess, KeptFrames& frames, double per_s);

/// Parts of equal duration; of more than `most_windows` those that lie evenly among them.
/// @throws std::runtime_error with too few keyframes
[[nodiscard]] std::vector<KeyframeWindow> windows_of(const std::vector<Keyframe>& keyframes,
                                                     const RecalibrateOptions& options);

/// A camera that moves by less than a baseline learns no depth that the pair itself does not claim: then
/// nothing tells a turned camera from other depths.
[[nodiscard]] bool moves(const KeyframeWindow& window, double baseline);

/// Of a prior of theta so vague that it says nothing.
[[nodiscard]] RigParameters vague_rig_sigma(double baseline);

/// What moves the body from frame to frame: all samples of a recording.
struct WindowInputs {
  std::span<const ImuSample> imu;
  std::span<const OdometrySample> odometry;
};

/// @throws UnsolvableError if the smoother finds no solution
[[nodiscard]] SmootherResult smooth_window(const KeyframeWindow& window, const WindowInputs& inputs,
                                           const StereoCalibration& given, const SmootherOptions& how);

/// What it says of the rig, without the prior.
[[nodiscard]] RigPart rig_part(SmootherResult result, const StereoCalibration& given,
                               const SmootherOptions& how);

/// @brief By what factor the assumed pixel noise is too small for the residuals that the smoother leaves in
/// the first window that it can solve; 1 if it can solve none.
[[nodiscard]] double noise_in_residuals(const std::vector<KeyframeWindow>& windows,
                                        const WindowInputs& inputs, const StereoCalibration& given,
                                        SmootherOptions how);

/// A sentence about a window that could not be solved.
[[nodiscard]] std::string left_out(const KeyframeWindow& window, std::int64_t begin_ns,
                                   const UnsolvableError& why);

}  // namespace limber::detail
