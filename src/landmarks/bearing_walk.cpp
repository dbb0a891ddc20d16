// SPDX-License-Identifier: MIT
#include "limber/landmarks/bearing_walk.hpp"

#include "limber/measure/stereo_model.hpp"

namespace limber {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Covariance of the landmark's triplet for a step of one radian, seen from the camera.
Matrix3d across_the_ray(const Estimate& estimate, const Landmark& landmark, const MountedCamera& cam0) {
  const BodyPoint point =
      body_point_at_exposure(cam0, estimate.nav().T_world_body, landmark, estimate.anchor_of(landmark));
  // From the camera: in units of the anchor's distance, or metres.
  const Vector3d away = point.Y - point.w * cam0.T_cam_body.inverse().p;
  if (landmark.kind == LandmarkKind::kInverseDepth) {
    return away.squaredNorm() * Vector3d(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix();
  }
  const Vector3d in_world = estimate.nav().T_world_body.R * away;
  return away.squaredNorm() * Matrix3d::Identity() - in_world * in_world.transpose();
}

}  // namespace

void walk_bearings(Estimate& estimate, const StereoFrame& frame, const MountedCamera& cam0,
                   const BearingWalk& walk) {
  for (const StereoObservation& observation : frame.observations) {
    const Landmark* landmark = observation.in_cam0 ? estimate.find(observation.track_id) : nullptr;
    if (landmark != nullptr && !landmark->passive && landmark->sightings >= walk.after) {
      const Matrix3d P = estimate.P().diagonal_block<3>(landmark->at);
      estimate.mutable_P().set_diagonal_block(
          landmark->at, Matrix3d(P + walk.sigma * walk.sigma * across_the_ray(estimate, *landmark, cam0)));
    }
  }
}

}  // namespace limber
