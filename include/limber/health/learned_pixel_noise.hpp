// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// What was learned of the pixels.
struct PixelNoiseReport {
  double sigma_px = 0.0;     ///< assumed, of white noise that would be as bad
  double correlation = 0.0;  ///< of a point's errors in two frames that follow each other, 0 to 1
  /// By what share lengths may be wrong that rest on the baseline alone, 1σ: half of the variance of what
  /// lasts is taken for common to all points (lenses), over their parallaxes. More frames do not average it
  /// out.
  double length_sigma = 0.0;
};

/// @brief The pixel noise that a filter has to assume where nobody stated it.
///
/// A filter takes errors for white. Those of real tracks are not: most of them stays while the track lives
/// and does not average out. So two things are learned. How alike a point's errors are from frame to frame:
/// from its distance to the epipolar line, without what a quadratic over the image explains (a wrong rig, a
/// lens); what lasts weighs as many frames as a point is seen. And how large innovations are beside what the
/// filter expected of them: NIS per degree of freedom has to be 1 for white errors, and 1 / `persistence()`
/// for lasting ones.
/// @note docs/evidence/realistic-pixels.md
class LearnedPixelNoise {
 public:
  /// @param begin  assumed until frames have told better [px]
  LearnedPixelNoise(const PixelNoise& begin, const StereoCalibration& calibration);

  /// A frame's stereo points, before the update.
  void see(const StereoFrame& frame);
  /// An update that assumed `sigma_px()`. @param nis  without what a rig that is trusted would explain
  void learn(double nis, double dof);

  /// Of u0, v0, u1, v1 [px]: to be assumed.
  [[nodiscard]] PixelNoise sigma_px() const { return begin_ * share_; }
  /// What has been learned so far.
  [[nodiscard]] PixelNoiseReport report() const;
  /// Variance that white noise needs, over that of a single frame: 1 for white errors.
  [[nodiscard]] double persistence() const;
  /// So many frames, each with errors of sigma_px(), tell as much of a point's place in the image as what
  /// lasts lets know. Infinite for white errors.
  [[nodiscard]] double telling_frames() const;

 private:
  struct SeenPair {
    double error = 0.0;     // off its epipolar line, in rms of the frame
    double parallax = 0.0;  // [px]
  };
  [[nodiscard]] static std::map<std::int64_t, SeenPair> seen_pairs(const StereoFrame& frame,
                                                                   const StereoCalibration& calibration);
  [[nodiscard]] double correlation() const;
  [[nodiscard]] double lasting() const;
  [[nodiscard]] double length_sigma() const;

  PixelNoise begin_;
  StereoCalibration calibration_;
  double share_ = 1.0;  // of begin_
  double updates_ = 0.0;
  double products_, squares_;
  double seen_ = 0.0, tracks_ = 0.0;  // stereo points of all frames, and how many of them were new
  double parallaxes_ = 0.0, squared_parallaxes_ = 0.0;  // their sums [px], [px^2]
  std::map<std::int64_t, SeenPair> before_;             // by track, of the last frame
};

}  // namespace limber
