// SPDX-License-Identifier: MIT
#include "limber/stack/stack_frame.hpp"

#include <array>
#include <optional>

#include "limber/measure/point_rows.hpp"

namespace limber {

using Eigen::Index;

namespace {

/// A landmark with the projections that are to be stacked; a camera that is not used is empty.
struct Row {
  const StereoObservation* observation;
  const Landmark* landmark;
  std::array<std::optional<PointProjection>, 2> projections;

  [[nodiscard]] Index rows() const {
    return 2 * (Index{projections[0].has_value()} + Index{projections[1].has_value()});
  }
};

/// Projects a landmark into the cameras that are to be used. @return false if it does not project into one of
/// them
bool project_used(const Estimate& estimate, const MountedRig& rig, RemainingRows remaining, Row& row) {
  const auto seen_by = [&](const MountedCamera& mounted) {
    return body_point_at_exposure(mounted, estimate.nav().T_world_body, *row.landmark,
                                  estimate.anchor_of(*row.landmark));
  };
  BodyPoint point = seen_by(rig[0]);
  const std::array<bool, 2> used = {row.observation->in_cam0 && remaining == RemainingRows::kAll,
                                    row.observation->in_cam1 && remaining != RemainingRows::kNone};
  for (std::size_t cam = 0; cam < 2; ++cam) {
    if (used[cam]) {
      if (rig[cam].time_offset_s != rig[0].time_offset_s) {
        point = seen_by(rig[cam]);
      }
      row.projections[cam] = project_point(rig[cam], point);
      if (!row.projections[cam]) {
        return false;
      }
      estimate.refer_to_epoch(*row.landmark, *row.projections[cam]);
    }
  }
  return true;
}

}  // namespace

StackedFrame stack_frame(const Estimate& estimate, const StereoFrame& frame, const MountedRig& rig,
                         const PixelNoise& sigma_px,
                         const std::unordered_map<std::int64_t, RemainingRows>& new_landmarks,
                         std::vector<Refusal>& refused) {
  std::vector<Row> points;
  Index m = 0;
  for (const StereoObservation& observation : frame.observations) {
    const Landmark* landmark = estimate.find(observation.track_id);
    if (landmark == nullptr) {
      continue;
    }
    const auto initialized = new_landmarks.find(observation.track_id);
    Row row{&observation, landmark, {}};
    if (!project_used(estimate, rig,
                      initialized == new_landmarks.end() ? RemainingRows::kAll : initialized->second, row)) {
      refused.push_back({observation.track_id, RefusalReason::kNotProjectable, 0.0, 0.0});
    } else if (row.rows() > 0) {
      m += row.rows();
      points.push_back(row);
    }
  }

  StackedFrame out;
  out.measurement = empty_measurement(m, jacobian_width(rig));
  Index at = 0;
  for (const Row& point : points) {
    out.measurement.groups.push_back({at, point.rows(), point.landmark->at});
    out.track_ids.push_back(point.observation->track_id);
    for (std::size_t cam = 0; cam < 2; ++cam) {
      if (point.projections[cam]) {
        write_point_rows(out.measurement, at,
                         cam == 0 ? point.observation->uv_cam0 : point.observation->uv_cam1,
                         sigma_px.segment<2>(2 * static_cast<Index>(cam)), *point.projections[cam],
                         *point.landmark, estimate.anchor_of(*point.landmark), estimate.layout());
        at += 2;
      }
    }
  }
  return out;
}

}  // namespace limber
