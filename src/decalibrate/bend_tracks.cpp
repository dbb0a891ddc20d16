// SPDX-License-Identifier: MIT
#include "limber/decalibrate/bend_tracks.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "limber/datasets/interpolate.hpp"
#include "limber/measure/rig.hpp"
#include "limber/measure/triangulate.hpp"

namespace limber {
namespace {

/// One frame of a recording on its way through the bend.
class FrameBender {
 public:
  FrameBender(const Recording& recording, const BentRig& rig, std::int64_t t_ns)
      : recording_(recording),
        before_(pose_from_rig(rig.before(t_ns))),
        after_(pose_from_rig(rig.after(t_ns))),
        turn_(rig.turn_of_cam1(t_ns)),
        shift_(after_.p - turn_ * before_.p) {
    if (recording.truth.landmarks.empty()) return;
    if (const auto truth = groundtruth_at(recording.truth.motion.states, t_ns)) {
      T_cam1_world_ = before_ * (Pose{truth->R_world_body, truth->p_world_body} *
                                 body_from_cam0(recording.calibration, {t_ns, rig.before(t_ns)}))
                                    .inverse();
    }
  }

  /// Where the bent camera sees the right pixel; nothing where its model does not reach.
  [[nodiscard]] std::optional<Eigen::Vector2d> moved(const StereoObservation& point) const {
    const auto bearing = unproject(recording_.calibration.cam1, point.uv_cam1);
    if (!bearing) return std::nullopt;
    const auto seen =
        project(recording_.calibration.cam1, turn_ * *bearing + inverse_range(point, *bearing) * shift_);
    return seen ? std::optional(seen->uv) : std::nullopt;
  }

  /// Whether the point has a depth, or needs none.
  [[nodiscard]] bool has_depth(const StereoObservation& point) const {
    return shift_.isZero(0.0) || point.in_cam0 || landmark(point);
  }

 private:
  /// In cam1.
  [[nodiscard]] std::optional<Eigen::Vector3d> landmark(const StereoObservation& point) const {
    const auto found = recording_.truth.landmarks.find(point.track_id);
    if (!T_cam1_world_ || found == recording_.truth.landmarks.end()) return std::nullopt;
    return *T_cam1_world_ * found->second;
  }

  /// 1 / distance from cam1 [1/m].
  [[nodiscard]] double inverse_range(const StereoObservation& point, const Eigen::Vector3d& bearing1) const {
    if (shift_.isZero(0.0)) return 0.0;
    if (const auto X = landmark(point)) return 1.0 / X->norm();
    const auto bearing0 = unproject(recording_.calibration.cam0, point.uv_cam0);
    if (!bearing0) return 0.0;
    return std::max(0.0, inverse_depth_along(bearing1, *bearing0, before_.inverse()).value_or(0.0));
  }

  const Recording& recording_;
  Pose before_, after_;  ///< T_cam1_cam0
  Eigen::Matrix3d turn_;
  Eigen::Vector3d shift_;  ///< X_after = turn X_before + shift
  std::optional<Pose> T_cam1_world_;
};

}  // namespace

TrackBending bend_tracks(const Recording& recording, const BentRig& rig) {
  if (recording.frames.empty())
    throw std::invalid_argument("bend_tracks: the recording has no matched points");
  TrackBending result;
  result.recording = recording;
  for (StereoFrame& frame : result.recording.frames) {
    const FrameBender bender(recording, rig, frame.t_ns);
    for (StereoObservation& point : frame.observations) {
      if (!point.in_cam1) continue;
      const bool has_depth = bender.has_depth(point);
      const auto uv = has_depth ? bender.moved(point) : std::nullopt;
      point.in_cam1 = uv && in_image(recording.calibration.cam1, *uv);
      result.points += point.in_cam1;
      result.left_image += has_depth && !point.in_cam1;
      result.without_depth += !has_depth;
      if (point.in_cam1) point.uv_cam1 = *uv;
    }
    std::erase_if(frame.observations,
                  [](const StereoObservation& point) { return !point.in_cam0 && !point.in_cam1; });
  }
  result.recording.truth.rig = rig.truth();
  return result;
}

}  // namespace limber
