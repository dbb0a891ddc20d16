// SPDX-License-Identifier: MIT
// On a robot: nothing is known of the start. Samples come first to a SensorStart, then to a Navigator.
#include <limber/initialize/sensor_start.hpp>
#include <limber/navigate/navigator.hpp>
#include <limber/simulate/simulator.hpp>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <optional>

int main() {
  limber::Scenario scenario;  // in place of your drivers; a small rig with an IMU at 200 Hz
  scenario.duration = 8.0;
  scenario.imu_rate = 200.0;
  const limber::Recording robot = limber::simulate(scenario, 1);

  limber::NavigatorOptions options;
  options.imu_noise = *robot.imu_noise;
  options.sigma_px = *robot.pixel_noise;
  limber::SensorStart start(options, robot.calibration);
  std::optional<limber::Navigator> navigator;

  std::size_t next = 0;
  for (const limber::StereoFrame& frame : robot.frames) {
    // Inputs up to the frame's time or just beyond, then the frame.
    for (; next < robot.imu.size() && (next == 0 || robot.imu[next - 1].t_ns < frame.t_ns); ++next) {
      navigator ? navigator->add_imu(robot.imu[next]) : start.add_imu(robot.imu[next]);
    }
    if (navigator) {
      navigator->process(frame);
      continue;
    }
    const limber::StartReport report = start.add_frame(frame);
    if (report.status != limber::StartStatus::kWaiting) {
      std::cout << "started after " << report.waited_s << " s, tilt known to " << report.tilt_sigma
                << " rad, scale to " << 100.0 * report.scale_sigma << " %\n";
      navigator.emplace(options, robot.calibration, start.result().initial);
      next -= std::min<std::size_t>(next, 2);  // the navigator wants the samples around its start, too
    }
  }
  if (!navigator) {
    std::cout << "no start\n";
    return EXIT_FAILURE;
  }
  const limber::Estimate& estimate = navigator->estimate();
  std::cout << "position " << estimate.nav.T_world_body.p.transpose() << " m, sigma "
            << estimate.P.diagonal_block<3>(0).diagonal().cwiseSqrt().transpose() << " m\n";
  return EXIT_SUCCESS;
}
