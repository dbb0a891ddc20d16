// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "limber/render/picture.hpp"
#include "limber/simulate/simulator.hpp"

namespace limber {

/// What images of a scenario are like. By default nothing disturbs them.
struct PictureOptions {
  /// which world
  SceneKind scene = SceneKind::kRoom;
  double noise = 0.0;  ///< sigma [grey levels]
  double gain_difference =
      0.0;                  ///< the right camera is darker by this share; both swing by half of it within 7 s
  double vignetting = 0.0;  ///< light lost in the corners, 0 to 1
  double exposure = 0.0;    ///< [s], around the instant of the row: motion blur
  double rolling_shutter =
      0.0;  ///< [s] from the first row to the one below the last; the stamp is its middle
  bool tell_readout =
      false;                 ///< the recording's calibration says rolling_shutter; else it says nothing of it
  int moving_objects = 0;    ///< boxes that move
  double low_texture = 0.0;  ///< share of the area of all walls that is nearly plain, 0 to 1
  double dropped = 0.0;      ///< share of frames without the image of one camera; never the first frame
  double swapped = 0.0;      ///< share of frames whose images are exchanged
};

/// @brief What the images of a scenario show, exactly: where the cameras are at any time, what is at any
/// pixel, and where it is in any other image. Cameras: 0 is left, 1 right. Times count from the start of
/// the recording; before it and after its end the rig stands still.
class PictureTruth {
 public:
  /// @throws as simulate; std::invalid_argument if an option makes no sense, or if there is no room for as
  /// many moving objects
  PictureTruth(const Scenario& scenario, const PictureOptions& options, std::uint64_t seed,
               std::uint64_t run);

  /// The world with its boxes.
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const StereoCalibration& nominal() const { return calibration_; }  ///< as estimators know it

  /// When row v of an image is exposed (its middle) [s]: stamp + (v / height - 1/2) rolling_shutter.
  [[nodiscard]] double time_of_row(std::size_t camera, std::int64_t stamp_ns, double v) const;

  /// T_world_cam at t [s]; the rig is bent as it is then.
  [[nodiscard]] View view(std::size_t camera, double t) const;

  /// What is seen at a pixel [px]; nothing for the sky, or where the lens shows nothing.
  [[nodiscard]] std::optional<Place> place(std::size_t camera, std::int64_t stamp_ns,
                                           const Eigen::Vector2d& uv) const;

  /// The pixel at which an image shows a place, if nothing hides it (compare with `place` of that pixel);
  /// it may lie outside of the image. Nothing where the lens does not show it.
  [[nodiscard]] std::optional<Eigen::Vector2d> pixel(std::size_t camera, std::int64_t stamp_ns,
                                                     const Place& place) const;

  /// Whether one thing stands in front of another within `radius` [px] of a pixel, at a distance that
  /// differs by a fifth: a point tracked there is no place.
  [[nodiscard]] bool on_an_edge(std::size_t camera, std::int64_t stamp_ns, const Eigen::Vector2d& uv,
                                double radius = 8.0) const;

 private:
  [[nodiscard]] const Camera& lens(std::size_t camera) const {
    return camera == 0 ? calibration_.cam0 : calibration_.cam1;
  }

  double duration_, rolling_shutter_;
  SplineTrajectory trajectory_;
  Decalibration decalibration_;
  StereoCalibration calibration_;
  Scene scene_;
};

}  // namespace limber
