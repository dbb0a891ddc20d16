// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "limber/sensors/calibration.hpp"
#include "limber/sensors/samples.hpp"

namespace limber::detail {

/// Moves pixels to where they were at the stamp, where cameras expose their rows one after the other; see
/// FrameCleaner.
class RowTimes {
 public:
  explicit RowTimes(const StereoCalibration& assumed);

  /// @return number of points that wait for their second view: taken out of the frame
  std::size_t refer_to_stamp(StereoFrame& frame);

 private:
  /// A pixel when its row was exposed [s since the first frame].
  struct View {
    double t = 0.0;
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
  };
  using Path = std::vector<View>;  ///< the latest views, oldest first

  struct Point {
    std::array<Path, 2> paths;  ///< of cam0, cam1
  };

  [[nodiscard]] View view(std::size_t camera, double stamp_s, const Eigen::Vector2d& uv) const;
  [[nodiscard]] bool refer(const Point& point, double stamp_s, StereoObservation& o) const;
  static void extend(Path& path, const View& view);
  static Eigen::Vector2d place(const Path& path, double t);

  std::array<Camera, 2> cameras_;
  std::array<double, 2> readout_s_;
  std::optional<std::int64_t> origin_ns_;
  std::unordered_map<std::int64_t, Point> points_;  ///< by track_id, of the frame before
};

}  // namespace limber::detail
