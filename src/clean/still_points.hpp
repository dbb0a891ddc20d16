// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// Ends tracks that go with the camera; see FrameCleaner.
class StillPoints {
 public:
  explicit StillPoints(const StereoCalibration& assumed);

  /// Takes those that are known out of the frame. @return tracks that are found out with this one
  std::vector<std::int64_t> end(StereoFrame& frame);

 private:
  void compare_with(const StereoFrame& frame);
  void follow(const StereoFrame& frame);
  [[nodiscard]] std::unordered_set<std::int64_t> suspects() const;
  [[nodiscard]] std::vector<double> ways() const;
  [[nodiscard]] std::vector<std::int64_t> turned_away(const StereoFrame& frame) const;

  /// A track of the frame that is compared with.
  struct Compared {
    Eigen::Vector2d uv;     ///< there, in the left image [px]
    double strayed = 0.0;   ///< from there, the farthest since [px]
    bool followed = false;  ///< the last frame holds it
  };

  StereoCalibration assumed_;
  StereoFrame first_;  // that is compared with
  std::unordered_map<std::int64_t, Compared> compared_;
  std::unordered_set<std::int64_t> accused_, known_;  // by one test, by two
  double next_test_ = 0.0;                            // way of the usual point [px]
  std::size_t most_moving_ = 0;                       // points, of all frames since
};

}  // namespace limber::detail
