// SPDX-License-Identifier: MIT
#include "limber/health/rig_window.hpp"

#include <utility>

#include "limber/sensors/image_cell.hpp"

namespace limber {

namespace {

constexpr std::size_t kMostPoints = 12000;  // of a window

}  // namespace

RigWindow::RigWindow(const StereoCalibration& calibration) : collected_{calibration} {}

void RigWindow::add(const StereoFrame& frame, const Pose& T_world_cam0, bool follows) {
  if (collected_.frames.empty()) {
    collected_.from_ns = frame.t_ns;
    stretch_ = 0;
    collected_.points = 0;
  }
  collected_.to_ns = frame.t_ns;
  stretch_ += follows ? 0 : 1;
  detail::WatchedFrame& kept = collected_.frames.emplace_back(detail::WatchedFrame{T_world_cam0, {}});
  for (const StereoObservation& o : frame.observations) {
    if (!o.in_cam0 || !o.in_cam1 || collected_.points >= kMostPoints) {
      continue;
    }
    const auto d0 = unproject(collected_.calibration.cam0, o.uv_cam0),
               d1 = unproject(collected_.calibration.cam1, o.uv_cam1);
    if (d0 && d1 && d0->z() > 0.0 && d1->z() > 0.0) {
      kept.points.push_back({{o.track_id, stretch_},
                             *d0 / d0->z(),
                             *d1 / d1->z(),
                             image_cell(collected_.calibration.cam1, o.uv_cam1)});
      ++collected_.points;
    }
  }
}

WindowFit RigWindow::close() {
  detail::WatchedFrames begun{collected_.calibration};
  return WindowFit(std::exchange(collected_, std::move(begun)));
}

}  // namespace limber
