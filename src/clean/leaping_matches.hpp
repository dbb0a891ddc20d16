// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

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
/// had before; a rotation and a change of the baseline are fitted robustly to what is left. Explained: 95 %
/// of the points lie within a pixel or so of where they should, or as near as `usual_misfit` lets expect of
/// noisier ones, plus 15 % of the parallax along their epipolar lines for the change of depth; and the
/// baseline has changed by less than 80 % of its length.
/// @param usual_misfit  rig_misfit of two frames between which nothing leapt; 0: not known
[[nodiscard]] bool one_rig_explains(const StereoSights& before, const StereoSights& after,
                                    const Pose& T_cam1_cam0, double usual_misfit);

/// How far from its place the median point is after that fit, in such tolerances; 0 if that cannot be said.
[[nodiscard]] double rig_misfit(const StereoSights& before, const StereoSights& after,
                                const Pose& T_cam1_cam0);

/// Leaves out matches in the right image that leapt to something else, until they are back; see FrameCleaner.
class LeapingMatches {
 public:
  explicit LeapingMatches(const StereoCalibration& assumed);

  struct Outcome {
    std::size_t lost = 0;     ///< tracks that leapt with this frame
    bool rig_jumped = false;  ///< they leap, but as one rig
  };
  Outcome end(StereoFrame& frame);

 private:
  struct Lost {
    double parallax = 0.0;  // before it leapt
    std::int64_t since_ns = 0;
  };

  [[nodiscard]] bool has_returned(std::int64_t track, const StereoSight& sight, std::int64_t t_ns) const;
  [[nodiscard]] StereoSights sights_of(const StereoFrame& frame) const;

  StereoCalibration assumed_;
  Pose T_cam1_cam0_;
  std::unordered_map<std::int64_t, Lost> lost_;  // by track
  StereoSights earlier_, before_;                // the two frames before
  double usual_misfit_ = 0.0;  // of the last two frames that came before a leap, and did not leap
  bool leapt_before_ = false;
  std::int64_t before_ns_ = 0;
};

}  // namespace limber::detail
