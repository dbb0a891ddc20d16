// SPDX-License-Identifier: MIT
// A pose for the controller at the rate of the IMU: predict(t) between frames changes nothing.
#include <limber/navigate/navigator.hpp>
#include <limber/simulate/simulator.hpp>
#include <limber/state/initial_state.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>

int main() {
  limber::Scenario scenario;  // in place of your drivers
  scenario.duration = 5.0;
  scenario.imu_rate = 200.0;
  const limber::Recording robot = limber::simulate(scenario, 1);

  limber::NavigatorOptions options;
  options.imu_noise = *robot.imu_noise;
  options.sigma_px = *robot.pixel_noise;
  // A start that is known, say from a dock; examples/02_online_start.cpp has one from the sensors.
  const limber::GroundTruthState& dock = robot.truth.motion.states.front();
  limber::NavigationState nav;
  nav.T_world_body = {dock.R_world_body, dock.p_world_body};
  nav.v_world_body = dock.v_world_body;
  limber::Navigator navigator(options, robot.calibration,
                              limber::make_initial_state(nav, options.motion, {}));

  std::size_t frame = 0, poses = 0;
  double worst = 0.0;
  for (std::size_t k = 0; k < robot.imu.size(); ++k) {
    const std::int64_t t_ns = robot.imu[k].t_ns;
    navigator.add_imu(robot.imu[k]);
    for (; frame < robot.frames.size() && robot.frames[frame].t_ns <= t_ns; ++frame) {
      navigator.process(robot.frames[frame]);
    }
    const limber::PredictedState pose = navigator.predict(t_ns);  // to the controller
    ++poses;
    worst = std::max(worst, (pose.nav.T_world_body.p - robot.truth.motion.states[k].p_world_body).norm());
  }
  std::cout << poses << " poses from " << frame << " frames, " << worst << " m off at worst\n";
  return poses == robot.imu.size() && worst < 0.2 ? EXIT_SUCCESS : EXIT_FAILURE;
}
