// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "limber/core/pose.hpp"
#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// A point that both cameras see, as the assumed rig has it.
struct StereoSight {
  Eigen::Vector3d turned;  ///< bearing in cam0, turned into cam1: unit
  Eigen::Vector3d right;   ///< bearing in cam1: unit
  double parallax = 0.0;   ///< angle between them [rad]
};

using StereoSights = std::unordered_map<std::int64_t, StereoSight>;  ///< by track

/// @brief Whether one change of theta explains how the right bearings of shared points moved.
/// The right bearing of each point in the later frame is predicted from its left one and the parallax that it
/// had before; a rotation and a change of the baseline are fitted robustly to what is left. Explained: four
/// points in five lie within 3 px or so of where they should, plus 15 % of the parallax along their epipolar
/// lines for the change of depth; and the baseline has changed by less than half its length.
[[nodiscard]] bool one_rig_explains(const StereoSights& before, const StereoSights& after,
                                    const Pose& T_cam1_cam0);

/// Ends matches in the right image that leapt to something else; see FrameCleaner.
class LeapingMatches {
 public:
  explicit LeapingMatches(const StereoCalibration& assumed);

  struct Outcome {
    std::size_t lost = 0;     ///< tracks whose match ended with this frame
    bool rig_jumped = false;  ///< they leap, but as one rig
  };
  Outcome end(StereoFrame& frame);

 private:
  [[nodiscard]] StereoSights sights_of(const StereoFrame& frame) const;

  StereoCalibration assumed_;
  Pose T_cam1_cam0_;
  std::unordered_set<std::int64_t> lost_;
  StereoSights before_;
  std::int64_t before_ns_ = 0;
};

}  // namespace limber::detail
