// SPDX-License-Identifier: MIT
// The loop of python_steps.py in C++: clean, start from the sensors, add_imu, process, estimate.
//   steps TRACK_LOG METHOD     prints processor time [s] and the last position [m]
#include <fmt/format.h>

#include <ctime>
#include <exception>
#include <iostream>
#include <optional>

#include "limber/clean/frame_cleaner.hpp"
#include "limber/datasets/read_recording.hpp"
#include "limber/initialize/sensor_start.hpp"
#include "limber/navigate/navigator.hpp"
#include "limber/run/run_options.hpp"

namespace {

/// Where the body is at the end.
Eigen::Vector3d by_hand(const limber::Recording& recording, const limber::RunSetup& setup) {
  limber::FrameCleaner cleaner(setup.calibration, {});
  limber::SensorStart start(setup.navigator, setup.calibration);
  std::optional<limber::Navigator> navigator;
  auto imu = recording.imu.begin();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (const limber::StereoFrame& raw : recording.frames) {
    const limber::StereoFrame frame = cleaner.clean(raw);
    for (bool beyond = false; imu != recording.imu.end() && !beyond; ++imu) {
      beyond = imu->t_ns >= frame.t_ns;
      navigator ? navigator->add_imu(*imu) : start.add_imu(*imu);
    }
    if (navigator) {
      (void)navigator->process(frame);
      p = navigator->estimate().nav().T_world_body.p;
    } else if (start.add_frame(frame).status != limber::StartStatus::kWaiting) {
      navigator.emplace(setup.navigator, setup.calibration, start.result().initial);
      imu = recording.imu.begin();
    }
  }
  return p;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: steps TRACK_LOG METHOD\n";
    return 2;
  }
  try {
    const limber::Recording recording = limber::read_recording(argv[1]);
    limber::RunOptions options;
    options.method = limber::method_from_string(argv[2]);
    const limber::RunSetup setup = limber::set_up_run(recording, options);
    const std::clock_t begin = std::clock();
    const Eigen::Vector3d p = by_hand(recording, setup);
    fmt::print("{} {:.17g} {:.17g} {:.17g}\n", static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC,
               p.x(), p.y(), p.z());
  } catch (const std::exception& error) {
    std::cerr << "steps: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
