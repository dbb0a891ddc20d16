// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "limber/frontend/grey_image.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber {

/// What the tracker looks for and what it believes.
struct TrackerOptions {
  int max_tracks = 120;           ///< points followed at a time
  double min_distance_px = 20.0;  ///< between a new point and every other one
  double min_corner_strength =
      15.0;  ///< smaller eigenvalue of the mean structure tensor [(grey level / px)^2]

  double min_ncc = 0.8;                  ///< correlation [-] of a matched patch with what was looked for
  double max_forward_backward_px = 1.0;  ///< distance to where the way back ends
  double max_epipolar_px = 1.0;          ///< Sampson distance to what most points of the frame agree on

  // Where a point may lie in the right image, before anything is known about it: between infinity and the
  // nearest distance as the assumed calibration has it, widened as a rig that is turned by the margin would.
  double nearest_baselines = 4.0;      ///< nearest distance, in baselines
  double search_margin_degrees = 6.0;  ///< that much the rig may be turned, and some room
};

/// @brief Images in, stereo tracks out: corners, followed in the left camera, matched into the right one.
///
/// The left track uses the left camera's intrinsics only. The right match is a search in two dimensions,
/// accepted by correlation, by the way back, and by agreement with the left-right geometry that the matches
/// of this and recent frames themselves show. The assumed extrinsics only place the search window.
/// Where the left image goes on from the right one before, and the right from the left, the two are put
/// back (StereoFrame::put_back); for a second at most, and not among the first three pairs. Deterministic:
/// the same images give the same bits, on any number of threads.
class StereoTracker {
 public:
  /// @param assumed  the rig as it is believed to be; resolutions must be set
  /// @throws std::invalid_argument if a resolution, a focal length or an option makes no sense
  explicit StereoTracker(const StereoCalibration& assumed, const TrackerOptions& options = {});
  ~StereoTracker();
  /// The other one may then only be destroyed or assigned to.
  StereoTracker(StereoTracker&&) noexcept;
  /// The other one may then only be destroyed or assigned to.
  StereoTracker& operator=(StereoTracker&&) noexcept;

  /// @brief Follows the points into the next stereo pair.
  /// @param t_ns    time of the pair [ns], later than that of the one before
  /// @param image0  file of the left image, as ImageReader takes it
  /// @param image1  file of the right image
  /// @return the points in raw (distorted) pixels, by rising track_id; all are in_cam0, and in_cam1 where the
  ///         right match can be trusted
  /// @throws DataError if a file cannot be read as an image, or has not its camera's resolution;
  ///         std::invalid_argument if time does not advance. The tracker is then as it was.
  [[nodiscard]] StereoFrame process(std::int64_t t_ns, const std::filesystem::path& image0,
                                    const std::filesystem::path& image1);

  /// @brief The same on images in memory, which are not needed after the call.
  /// @throws std::invalid_argument if an image has not its camera's resolution, or time does not advance.
  [[nodiscard]] StereoFrame process(std::int64_t t_ns, const GreyImage& image0, const GreyImage& image1);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limber
