// SPDX-License-Identifier: MIT
// The smallest complete use of limber::filter: a rig at rest before a wall, its right camera one degree off.
#include <limber/navigate/navigator.hpp>
#include <limber/state/initial_state.hpp>

#include <iostream>

int main() {
  // What the filter may assume: two pinhole cameras 12 cm apart, the left one looking along the body's x.
  limber::StereoCalibration assumed;
  assumed.cam0 = assumed.cam1 = {455.0, 455.0, 376.0, 240.0, 752, 480, limber::NoDistortion{}};
  assumed.theta << 0.0, 0.0, 0.0, -0.12, 0.0, 0.0;
  assumed.T_body_cam0.R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;

  limber::NavigatorOptions options;
  options.method = limber::Method::kLcekf;  // all six parameters of the rig may be wrong
  limber::Navigator navigator(options, assumed, limber::make_initial_state({}, options.motion, {}));

  // The truth, which the filter never sees.
  limber::RigParameters theta_true = assumed.theta;
  theta_true(1) += 0.0175;
  const limber::Pose T_cam1_cam0 = limber::pose_from_rig(theta_true);

  limber::FrameReport report;
  for (int frame = 0; frame <= 20; ++frame) {
    const std::int64_t t_ns = frame * 50'000'000LL;
    for (int sample = 0; sample < 10; ++sample) {
      navigator.add_imu({t_ns + sample * 5'000'000LL, Eigen::Vector3d::Zero(), {0.0, 0.0, 9.81}});
    }
    limber::StereoFrame seen{t_ns, {}};
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d X_cam0(k % 5 - 2.0, k / 5 - 1.5, 6.0 + k % 3);
      seen.observations.push_back({k, project(assumed.cam0, X_cam0)->uv,
                                   project(assumed.cam1, T_cam1_cam0 * X_cam0)->uv, true, true});
    }
    report = navigator.process(seen);
  }
  const limber::NavigationState& state = navigator.estimate().nav();
  std::cout << "moved " << 1e3 * state.T_world_body.p.norm() << " mm in one second at rest, " << report.used
            << " points used, " << report.refused.size() << " refused, " << report.rank
            << " directions of the rig ignored\n";
}
