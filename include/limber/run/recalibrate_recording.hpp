// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "limber/run/rig_parts.hpp"
#include "limber/run/run_recording.hpp"

/// @file
/// A corrected calibration out of a recording. There only if limber was built with Ceres
/// (LIMBER_BUILD_SMOOTH).
namespace limber {

/// What may become of a calibration.
enum class RecalibrationVerdict : std::uint8_t {
  kBetter,           ///< off by more than the tolerance, and the new one is better where it was not made
  kWithinTolerance,  ///< the given one is good enough: nothing to mend
  kNotBetter,        ///< the rest of the recording does not confirm the new one
  kCannotTell        ///< the interval of what was found reaches from inside the tolerance to outside
};

/// "better", "within tolerance", "not better", "cannot tell".
[[nodiscard]] std::string to_string(RecalibrationVerdict verdict);

/// What is assumed, how a recording is cut up, what is asked for.
struct RecalibrateOptions {
  RunOptions run;  ///< what is assumed, and how the filter starts that gives the first guess
  /// length of a part that is solved on its own [s]
  double window_s = 10.0;
  std::size_t most_windows = 12;  ///< of a long recording those are taken that lie evenly in it
  /// frames that are taken of a window [1/s]
  double keyframes_per_s = 5.0;
  std::size_t points = 120;  ///< of a keyframe at most
  /// An axis is seen if its standard deviation is below: 0.2 deg, 5 % of the baseline.
  double seen_angle = 0.2 * 3.14159265358979323846 / 180.0, seen_share = 0.05;
  // Within tolerance is what moves points by less from their epipolar lines (rms) and changes depths by less.
  /// [px], and as a share of the depth
  double tolerance_px = 0.3, tolerance_depth = 0.05;
  double baselines = 90.0;  ///< the depth where tolerance_depth holds
  /// of the solver
  int threads = 1;
};

/// A number before and after.
struct BeforeAfter {
  /// with the given rig and with the fitted one, in the unit of what is compared
  double given = 0.0, fitted = 0.0;
};

/// Depth of a point straight ahead, measured with the given rig if the fitted one is true.
struct DepthChange {
  double depth = 0.0;               ///< [m]
  double share = 0.0, sigma = 0.0;  ///< measured minus true over true; infinite where rays do not meet
};

/// What was found, before and after, and the verdict.
struct Recalibration {
  /// whether the fitted one is to be preferred
  RecalibrationVerdict verdict = RecalibrationVerdict::kCannotTell;
  /// given: as assumed; fitted: with the theta that was found
  StereoCalibration given, fitted;
  /// theta and its covariance
  RigFit fit;
  bool length_seen = true;          ///< false: nothing but the baseline's length fixes the scale
  BeforeAfter epipolar_px;          ///< root mean square over the points of the keyframes (outliers clipped)
  double epipolar_change_px = 0.0;  ///< root mean square of what the correction moves
  double epipolar_sigma_px = 0.0;   ///< of that, by the covariance
  DepthChange at_tolerance;         ///< at `baselines`
  std::vector<DepthChange> depths;  ///< at 5, 10, 20 m
  /// windows judged by a rig that they had no part in
  HeldOut held_out;
  /// those that were solved, in order of time
  std::vector<RigPart> windows;
  /// over all windows
  std::size_t keyframes = 0;
  /// windows that were left out, choices, in plain words
  std::vector<std::string> notes;
};

/// @brief Estimates the rig theta as one constant, window by window through the smoother, and judges whether
/// the result is to be preferred to what was given.
///
/// The windows' own covariances say what the sensors' noise does; the differences between windows say how
/// much worse it is. The rig of every second window is judged by the windows between, and the reverse.
/// @param progress  told of work in per cent; may be empty
/// @throws as run_recording; UnsolvableError if no window can be solved; notes say which
/// windows were left out, and why
[[nodiscard]] Recalibration recalibrate_recording(const Recording& recording,
                                                  const RecalibrateOptions& options,
                                                  const FrameSource& source,
                                                  const std::function<void(std::size_t)>& progress = {});

}  // namespace limber
