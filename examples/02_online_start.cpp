// SPDX-License-Identifier: MIT
// On a robot nothing is known of the start: an OnlineNavigator takes samples and frames from the first one
// on. A thread that must not wait for the start, some tenths of a second, takes a BackgroundNavigator.
#include <limber/initialize/online_navigator.hpp>
#include <limber/simulate/simulator.hpp>

#include <cstdlib>
#include <iostream>
#include <string>

int main() {
  limber::Scenario scenario;  // in place of your drivers; a small rig with an IMU at 200 Hz
  scenario.duration = 12.0;
  scenario.imu_rate = 200.0;
  const limber::Recording robot = limber::simulate(scenario, 1);

  limber::NavigatorOptions options;
  options.imu_noise = *robot.imu_noise;
  options.sigma_px = *robot.pixel_noise;
  limber::StartOptions start;
  start.longest_fine_s = 4.0;  // a finer scale is worth that wait to this robot; default: up to 16 s
  limber::OnlineNavigator navigator(options, robot.calibration, start);

  std::string missing;
  auto imu = robot.imu.begin();
  for (const limber::StereoFrame& frame : robot.frames) {
    for (; imu != robot.imu.end() && imu->t_ns <= frame.t_ns; ++imu) {
      navigator.add_imu(*imu);
    }
    const limber::OnlineReport report = navigator.process(frame);
    if (!report.start) {
      continue;  // started: report.frame is what the filter made of it
    }
    if (report.start->status != limber::StartStatus::kWaiting) {
      std::cout << "started after " << report.start->waited_s << " s, tilt known to "
                << report.start->tilt_sigma << " rad, scale to " << 100.0 * report.start->scale_sigma
                << " %\n";
    } else if (report.start->missing != missing) {
      missing = report.start->missing;
      std::cout << "waits for: " << missing << "\n";
    }
  }
  if (!navigator.started()) {
    std::cout << "no start\n";
    return EXIT_FAILURE;
  }
  const limber::Estimate& estimate = navigator.estimate();
  std::cout << "position " << estimate.nav().T_world_body.p.transpose() << " m, sigma "
            << estimate.P().diagonal_block<3>(0).diagonal().cwiseSqrt().transpose() << " m\n"
            << "the rig is " << to_string(navigator.health()->verdict) << "\n";
  return EXIT_SUCCESS;
}
