// SPDX-License-Identifier: MIT
// Images in: grey pixels in memory become matched points, ready for a Navigator.
#include <limber/frontend/stereo_tracker.hpp>

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <random>
#include <vector>

namespace {

constexpr int kWidth = 320, kHeight = 240, kWall = 480, kDisparity = 8;

/// A wall of random grey squares, in place of your camera driver.
std::vector<std::uint8_t> paint_wall() {
  std::mt19937 random(7);
  std::vector<std::uint8_t> squares(static_cast<std::size_t>(kWall / 8 * kHeight / 8));
  for (std::uint8_t& grey : squares) {
    grey = static_cast<std::uint8_t>(random() % 256);
  }
  std::vector<std::uint8_t> wall(static_cast<std::size_t>(kWall * kHeight));
  for (int k = 0; k < kWall * kHeight; ++k) {
    const int u = k % kWall / 8, v = k / kWall / 8;
    wall[static_cast<std::size_t>(k)] = squares[static_cast<std::size_t>(v * (kWall / 8) + u)];
  }
  return wall;
}

}  // namespace

int main() {
  limber::StereoCalibration assumed;
  assumed.cam0 = assumed.cam1 = {200.0, 200.0, 160.0, 120.0, kWidth, kHeight, limber::NoDistortion{}};
  assumed.theta << 0.0, 0.0, 0.0, -0.2, 0.0, 0.0;
  limber::StereoTracker tracker(assumed);

  const std::vector<std::uint8_t> wall = paint_wall();
  limber::StereoFrame frame;
  for (int n = 0; n < 5; ++n) {  // the rig moves to the right, a pixel a frame; rows lie kWall bytes apart
    const limber::GreyImage left = {kWidth, kHeight, kWall, wall.data() + 40 + n};
    const limber::GreyImage right = {kWidth, kHeight, kWall, wall.data() + 40 + n + kDisparity};
    frame = tracker.process(n * 50'000'000LL, left, right);
  }
  std::size_t matched = 0, right_depth = 0;
  for (const limber::StereoObservation& point : frame.observations) {
    matched += point.in_cam1 ? 1 : 0;
    right_depth += point.in_cam1 && std::abs((point.uv_cam0 - point.uv_cam1).x() - kDisparity) < 0.2 ? 1 : 0;
  }
  std::cout << frame.observations.size() << " points, " << matched << " in both images, " << right_depth
            << " of them at the wall's depth\n";
  return matched > 20 && right_depth > 9 * matched / 10 ? EXIT_SUCCESS : EXIT_FAILURE;
}
