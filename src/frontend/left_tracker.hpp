// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "frontend/epipolar.hpp"
#include "frontend/patch.hpp"
#include "frontend/pyramid.hpp"
#include "limber/frontend/stereo_tracker.hpp"

namespace limber::frontend {

/// A point that is followed through the images of the left camera.
struct LeftTrack {
  std::int64_t id = 0;
  std::vector<Eigen::Vector2d> path;                    ///< [px] in the latest frames, this one last
  std::shared_ptr<const Patch> reference;               ///< what it looked like at first
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();  ///< of the reference in this frame
  double rest = 0.0;  ///< what the reference does not explain in this frame, rms [grey levels]

  [[nodiscard]] const Eigen::Vector2d& uv() const { return path.back(); }
};

/// @brief Follows corners through the images of one camera. Knows nothing of the other one.
/// Pyramidal alignment of the latest view [Lucas1981, Bouguet2001, Baker2004], then of the first one, which a
/// track does not outlive; what disagrees with the motion that most tracks show, from frame to frame or over
/// several, is dropped.
class LeftTracker {
 public:
  LeftTracker(const Camera& camera, const TrackerOptions& options) : camera_(camera), options_(options) {}

  /// Takes the next image, whose pixels must stay as they are.
  void follow(const Pyramid& image);

  [[nodiscard]] const std::vector<LeftTrack>& tracks() const { return tracks_; }  ///< by rising id

 private:
  [[nodiscard]] Eigen::Vector2d expected_flow(const LeftTrack& track) const;
  [[nodiscard]] Eigen::Vector2d coarse_place(const LeftTrack& track, const Pyramid& next) const;
  [[nodiscard]] bool advance(LeftTrack& track, const Eigen::Vector2d& start, const Pyramid& next) const;
  void drop_changed();
  void drop_contradicted(std::size_t lag, std::optional<EpipolarGeometry>& motion);
  void drop_crowded();
  void add_corners();

  Camera camera_;
  TrackerOptions options_;
  Pyramid image_;  ///< where the tracks are now
  std::vector<LeftTrack> tracks_;
  std::optional<EpipolarGeometry> motion_, long_motion_;  ///< over one frame, and over several
  std::int64_t next_id_ = 0;
};

}  // namespace limber::frontend
