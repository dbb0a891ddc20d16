// SPDX-License-Identifier: MIT
// What an embedded user writes: includes limber, links limber::filter, knows Eigen and nothing else.
// One second at rest before a wall of points, with a right camera that stands one degree off.
#include <limber/navigate/stereo_filter.hpp>
#include <limber/state/initial_state.hpp>

#include <cstdint>
#include <cstdlib>
#include <iostream>

namespace {

limber::StereoCalibration assumed_calibration() {
  limber::StereoCalibration calibration;
  calibration.cam0 = {455.0, 455.0, 376.0, 240.0, 752, 480, limber::NoDistortion{}};
  calibration.cam1 = calibration.cam0;
  calibration.theta << 0.0, 0.0, 0.0, -0.12, 0.0, 0.0;
  calibration.T_body_cam0.R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;  // x forward, z up
  return calibration;
}

limber::StereoFrame frame_at(std::int64_t t_ns, const limber::StereoCalibration& assumed) {
  limber::RigParameters theta_true = assumed.theta;
  theta_true(1) += 0.0175;
  limber::StereoFrame frame{t_ns, {}};
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d X_cam0(k % 5 - 2.0, k / 5 - 1.5, 6.0 + k % 3);
    limber::StereoObservation observation;
    observation.track_id = k;
    observation.uv_cam0 = limber::project(assumed.cam0, X_cam0)->uv;
    observation.uv_cam1 = limber::project(assumed.cam1, limber::pose_from_rig(theta_true) * X_cam0)->uv;
    frame.observations.push_back(observation);
  }
  return frame;
}

}  // namespace

int main() {
  const limber::StereoCalibration calibration = assumed_calibration();
  limber::NavigatorOptions options;
  options.method = limber::Method::kLcekf;
  const auto initial = limber::make_initial_state({}, options.motion, {});
  limber::StereoFilter navigator(options, calibration, initial);

  limber::FrameReport report;
  for (std::int64_t t_ms = 0; t_ms <= 1000; t_ms += 5) {
    navigator.add_imu({t_ms * 1000000, Eigen::Vector3d::Zero(), {0.0, 0.0, options.gravity}});
    if (t_ms % 50 == 0) {
      report = navigator.process(frame_at(t_ms * 1000000, calibration));
    }
  }

  const double moved = navigator.estimate().nav().T_world_body.p.norm();
  std::cout << "used " << report.used << " of " << report.observed << " points, moved " << moved << " m\n";
  const bool ok = report.status == limber::UpdateStatus::kUpdated && report.used == 20 && moved < 0.01;
  return ok ? EXIT_SUCCESS : EXIT_FAILURE;
}
